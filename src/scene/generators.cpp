#include "scene/generators.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/trigonometry.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

constexpr double max_index = std::numeric_limits<Index>::max();

void require(bool holds, const char* source, const char* where, const std::string& found,
             const char* expected) {
  if (!holds) throw Error(source, where, found, expected);
}

/// Whether check_mesh() accepts a coordinate of this size.
bool is_length(double x) {
  return x > 0.0 && x <= 1e100;
}

double signed_volume(const TetMesh& mesh, const Tet& tet) {
  const Vec3& a = at(mesh.points, tet[0]);
  return dot(at(mesh.points, tet[1]) - a, cross(at(mesh.points, tet[2]) - a, at(mesh.points, tet[3]) - a));
}

/// The corners of a cell are numbered x + 2 y + 4 z. The first tet is the middle one.
constexpr std::array<std::array<int, 4>, 5> even_cell{
    {{0, 3, 6, 5}, {1, 0, 5, 3}, {2, 0, 3, 6}, {4, 0, 6, 5}, {7, 3, 5, 6}}};

std::vector<Vec3> box_points(const std::array<int, 3>& cells, const Vec3& size) {
  const auto coordinate = [](double s, int i, int n) { return s * (static_cast<double>(i) / n - 0.5); };
  std::vector<Vec3> points;
  for (int k = 0; k <= cells[2]; ++k) {
    for (int j = 0; j <= cells[1]; ++j) {
      for (int i = 0; i <= cells[0]; ++i) {
        points.push_back({coordinate(size.x, i, cells[0]), coordinate(size.y, j, cells[1]),
                          coordinate(size.z, k, cells[2])});
      }
    }
  }
  return points;
}

/// Appends the tets of cell (i, j, k).
void add_cell(const std::array<int, 3>& cells, int i, int j, int k, std::vector<Tet>& tets) {
  const auto point = [&](int x, int y, int z) { return x + (cells[0] + 1) * (y + (cells[1] + 1) * z); };
  const bool odd = (i + j + k) % 2 != 0;
  for (const auto& corners : even_cell) {
    Tet tet{};
    for (std::size_t c = 0; c < 4; ++c) {
      const int x = (corners[c] & 1) ^ (odd ? 1 : 0);  // mirrored along x
      tet[c] = point(i + x, j + (corners[c] >> 1 & 1), k + (corners[c] >> 2));
    }
    if (odd) std::swap(tet[2], tet[3]);  // mirroring has inverted the tet
    tets.push_back(tet);
  }
}

std::vector<Tet> box_tets(const std::array<int, 3>& cells) {
  std::vector<Tet> tets;
  for (int k = 0; k < cells[2]; ++k) {
    for (int j = 0; j < cells[1]; ++j) {
      for (int i = 0; i < cells[0]; ++i) add_cell(cells, i, j, k, tets);
    }
  }
  return tets;
}

using Lattice = std::array<int, 3>;

/// A point of the ball's lattice: its weights for the (at most three) icosahedron corners around it, as
/// (corner, weight), ascending. The weights add up to its layer. A point has the same key in all tets of the
/// icosahedron that contain it.
using BallKey = std::vector<std::pair<int, int>>;

std::array<Vec3, 12> icosahedron_corners() {
  const double z = 1.0 / std::sqrt(5.0);
  const double ring = 2.0 * z;
  std::array<Vec3, 12> corners;
  corners[0] = {0.0, 0.0, 1.0};
  corners[11] = {0.0, 0.0, -1.0};
  for (std::size_t i = 0; i < 5; ++i) {
    const double angle = 2.0 * std::numbers::pi / 5.0 * static_cast<double>(i);
    const double turned = angle + std::numbers::pi / 5.0;
    corners[1 + i] = {ring * cosine(angle), ring * sine(angle), z};
    corners[6 + i] = {ring * cosine(turned), ring * sine(turned), -z};
  }
  return corners;
}

std::vector<std::array<int, 3>> icosahedron_faces() {
  std::vector<std::array<int, 3>> faces;
  for (int i = 0; i < 5; ++i) {
    const int next = (i + 1) % 5;
    faces.push_back({0, 1 + i, 1 + next});
    faces.push_back({1 + i, 6 + i, 1 + next});
    faces.push_back({6 + i, 6 + next, 1 + next});
    faces.push_back({11, 6 + next, 6 + i});
  }
  return faces;
}

/// The resolution^3 tets of a corner tet: lattice points (a, b, c) with resolution >= a >= b >= c >= 0, and
/// of each unit cube the six paths along the axes that stay inside. `a` is the layer.
std::vector<std::array<Lattice, 4>> lattice_tets(int resolution) {
  std::vector<std::array<Lattice, 4>> tets;
  const auto inside = [&](const Lattice& p) { return resolution >= p[0] && p[0] >= p[1] && p[1] >= p[2]; };
  for (int a = 0; a < resolution; ++a) {
    for (int b = 0; b <= a; ++b) {
      for (int c = 0; c <= b; ++c) {
        std::array<std::size_t, 3> axes{0, 1, 2};
        do {
          std::array<Lattice, 4> path{{{a, b, c}}};
          for (std::size_t step = 0; step < 3; ++step) {
            path[step + 1] = path[step];
            ++path[step + 1][axes[step]];
          }
          if (std::all_of(path.begin(), path.end(), inside)) tets.push_back(path);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
    }
  }
  return tets;
}

BallKey ball_key(const Lattice& p, const std::array<int, 3>& face) {
  BallKey key;
  const std::array<int, 3> weights{p[0] - p[1], p[1] - p[2], p[2]};
  for (std::size_t i = 0; i < 3; ++i) {
    if (weights[i] > 0) key.emplace_back(face[i], weights[i]);
  }
  std::sort(key.begin(), key.end());
  return key;
}

int layer_of(const BallKey& key) {
  int layer = 0;
  for (const auto& [corner, weight] : key) layer += weight;
  return layer;
}

Vec3 ball_point(const BallKey& key, const std::array<Vec3, 12>& corners, double radius, int resolution) {
  Vec3 direction;
  for (const auto& [corner, weight] : key) direction += static_cast<double>(weight) * at(corners, corner);
  return (radius * (static_cast<double>(layer_of(key)) / resolution)) * normalized(direction);
}

}  // namespace

TetMesh make_box(const std::array<int, 3>& cells, const Vec3& size) {
  double tets = 5.0;
  for (const int n : cells) {
    require(n >= 1, "box", "cells", std::to_string(n), "1 or more");
    tets *= n;
  }
  for (const double s : {size.x, size.y, size.z}) {
    require(is_length(s), "box", "size", number_text(s), "a number > 0, 1e100 at most");
  }
  require(4.0 * tets <= max_index, "box", "cells", number_text(tets) + " tets", "at most 536870911 tets");
  return {box_points(cells, size), box_tets(cells)};
}

TetMesh make_ball(double radius, int resolution) {
  require(is_length(radius), "ball", "radius", number_text(radius), "a number > 0, 1e100 at most");
  require(resolution >= 1 && resolution <= most_ball_resolution, "ball", "resolution",
          std::to_string(resolution), "1 to 256");

  const auto corners = icosahedron_corners();
  const auto faces = icosahedron_faces();
  const auto lattice = lattice_tets(resolution);
  std::map<std::pair<int, BallKey>, Index>
      index_of;  // sorted by layer first, so points are numbered layer by layer
  for (const auto& face : faces) {
    for (const auto& tet : lattice) {
      for (const Lattice& p : tet) index_of.emplace(std::pair(p[0], ball_key(p, face)), 0);
    }
  }
  TetMesh mesh;
  mesh.points.reserve(index_of.size());
  for (auto& [key, index] : index_of) {
    index = static_cast<Index>(mesh.points.size());
    mesh.points.push_back(ball_point(key.second, corners, radius, resolution));
  }
  mesh.tets.reserve(faces.size() * lattice.size());
  for (const auto& face : faces) {
    for (const auto& path : lattice) {
      Tet tet{};
      for (std::size_t c = 0; c < 4; ++c) tet[c] = index_of.at({path[c][0], ball_key(path[c], face)});
      if (signed_volume(mesh, tet) < 0.0) std::swap(tet[2], tet[3]);
      mesh.tets.push_back(tet);
    }
  }
  return mesh;
}

}  // namespace palpate

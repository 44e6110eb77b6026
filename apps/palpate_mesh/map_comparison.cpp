#include "map_comparison.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "contact/nearest_surface.hpp"
#include "geometry/box_tree.hpp"
#include "geometry/vector.hpp"
#include "sliver_repair.hpp"
#include "voxel_lines.hpp"

namespace palpate::app {
namespace {

using Triangle3 = std::array<Vec3, 3>;
using Segment3 = std::array<Vec3, 2>;

/// Calls f(voxel, voxel before, axis) for each pair of neighbouring voxels of different tissues, also at the
/// border of the map.
template <class Function>
void for_voxel_faces(const Tissues& tissues, Function&& f) {
  const auto& size = tissues.size();
  for_points({size[0] + 1, size[1] + 1, size[2] + 1}, [&](int i, int j, int k) {
    for (std::size_t a = 0; a < 3; ++a) {
      const std::array<int, 3> here{i, j, k};
      std::array<int, 3> before = here;
      --before[a];
      if (tissues.voxel(i, j, k) != tissues.voxel(before[0], before[1], before[2])) f(here, before, a);
    }
  });
}

int tissue_at(const Tissues& tissues, const std::array<int, 3>& v) {
  return tissues.voxel(v[0], v[1], v[2]);
}

/// The faces of the voxels of each tissue, two triangles each.
std::vector<std::vector<Triangle3>> voxel_surfaces(const Tissues& tissues) {
  std::vector<std::vector<Triangle3>> surfaces(static_cast<std::size_t>(tissues.count()) + 1);
  const Vec3 s = tissues.spacing();
  for_voxel_faces(tissues,
                  [&](const std::array<int, 3>& here, const std::array<int, 3>& before, std::size_t axis) {
                    const auto corner = [&](int u, int v) {
                      std::array<double, 3> p{here[0] - 0.5, here[1] - 0.5, here[2] - 0.5};
                      p[(axis + 1) % 3] += u;
                      p[(axis + 2) % 3] += v;
                      return Vec3{p[0] * s.x, p[1] * s.y, p[2] * s.z};
                    };
                    for (const int t : {tissue_at(tissues, here), tissue_at(tissues, before)}) {
                      auto& surface = surfaces[static_cast<std::size_t>(t)];
                      surface.push_back({corner(0, 0), corner(1, 0), corner(1, 1)});
                      surface.push_back({corner(0, 0), corner(1, 1), corner(0, 1)});
                    }
                  });
  return surfaces;
}

Triangle3 corners_of(const LabelledMesh& mesh, const InterfaceFace& face) {
  Triangle3 corners;
  for (std::size_t c = 0; c < 3; ++c) corners[c] = mesh.mesh.points[static_cast<std::size_t>(face.points[c])];
  return corners;
}

Vec3 middle_of(const Triangle3& t) {
  return (1.0 / 3.0) * (t[0] + t[1] + t[2]);
}

Vec3 middle_of(const Segment3& s) {
  return 0.5 * (s[0] + s[1]);
}

Vec3 nearest_on(const Triangle3& t, const Vec3& p) {
  return nearest_on_triangle(p, t);
}

Vec3 nearest_on(const Segment3& s, const Vec3& p) {
  return nearest_on_segment(p, s[0], s[1]);
}

/// Distance of p from the nearest of these triangles or segments.
/// \param tree  tree of their boxes
template <class Shape>
double distance_to(const Vec3& p, const std::vector<Shape>& shapes, const BoxTree& tree) {
  double least = std::numeric_limits<double>::infinity();
  tree.for_each_within(
      Box{p, p}, [&] { return least; },
      [&](std::size_t t) { least = std::min(least, length(nearest_on(shapes[t], p) - p)); });
  return least;
}

/// Distances from the corners and centroids of the triangles or segments of each shape to the other shape.
template <class Shape>
ShapeDistance distance_between(const std::vector<Shape>& a, const std::vector<Shape>& b) {
  if (a.empty() || b.empty()) return {};
  std::vector<double> distances;
  const auto add = [&](const std::vector<Shape>& from, const std::vector<Shape>& to) {
    std::vector<Box> boxes(to.size());
    for (std::size_t t = 0; t < to.size(); ++t) {
      for (const Vec3& corner : to[t]) boxes[t].extend(corner);
    }
    const BoxTree tree(std::move(boxes));
    for (const Shape& shape : from) {
      distances.push_back(distance_to(shape[0], to, tree));
      distances.push_back(distance_to(middle_of(shape), to, tree));
    }
  };
  add(a, b);
  add(b, a);
  std::ranges::sort(distances);
  ShapeDistance found;
  for (const double d : distances) found.mean += d / static_cast<double>(distances.size());
  found.largest = distances.back();
  found.percentile_95 = distances[(distances.size() - 1) * 95 / 100];
  return found;
}

void add_volumes(const LabelledMesh& mesh, std::vector<TissueMatch>& matches) {
  for (std::size_t t = 0; t < mesh.mesh.tets.size(); ++t) {
    std::array<Vec3, 4> p;
    for (std::size_t c = 0; c < 4; ++c)
      p[c] = mesh.mesh.points[static_cast<std::size_t>(mesh.mesh.tets[t][c])];
    TissueMatch& match = matches[static_cast<std::size_t>(mesh.labels[t] - 1)];
    ++match.tets;
    match.volume += dot(cross(p[1] - p[0], p[2] - p[0]), p[3] - p[0]) / 6.0;
    match.least_angle = std::min(match.least_angle, least_dihedral_angle(p));
  }
}

bool is_near(const VoxelLines& lines, const Tissues& tissues, const std::array<int, 3>& v, int tissue) {
  bool near = false;
  for_points({3, 3, 3}, [&](int i, int j, int k) {
    const std::array<int, 3> other{v[0] + i - 1, v[1] + j - 1, v[2] + k - 1};
    for (std::size_t a = 0; a < 3; ++a) {
      if (other[a] < 0 || other[a] >= tissues.size()[a]) return;
    }
    near = near || lines.tissues[tissues.voxel_index(other[0], other[1], other[2])] == tissue;
  });
  return near;
}

void add_voxels(const Tissues& tissues, const VoxelLines& lines, std::vector<TissueMatch>& matches) {
  const double voxel = tissues.spacing().x * tissues.spacing().y * tissues.spacing().z;
  std::vector<std::size_t> in_mesh(matches.size() + 1);
  std::vector<std::size_t> in_both(matches.size() + 1);
  for_points(tissues.size(), [&](int i, int j, int k) {
    const std::size_t v = tissues.voxel_index(i, j, k);
    const int tissue = tissues.voxels()[v];
    ++in_mesh[lines.tissues[v]];
    if (tissue == lines.tissues[v]) ++in_both[static_cast<std::size_t>(tissue)];
    if (tissue == 0) return;
    TissueMatch& match = matches[static_cast<std::size_t>(tissue - 1)];
    ++match.voxels;
    match.map_volume += voxel;
    if (tissue != lines.tissues[v] && !is_near(lines, tissues, {i, j, k}, tissue)) ++match.lost;
  });
  for (std::size_t m = 0; m < matches.size(); ++m) {
    matches[m].dice =
        2.0 * static_cast<double>(in_both[m + 1]) / static_cast<double>(matches[m].voxels + in_mesh[m + 1]);
  }
}

std::vector<InterfaceMatch> interfaces_of(const Tissues& tissues, const LabelledMesh& mesh,
                                          const VoxelLines& lines, const std::vector<InterfaceFace>& faces) {
  constexpr double closed = 0.1;  // mm
  const Vec3& s = tissues.spacing();
  const std::array<double, 3> step{s.x, s.y, s.z};
  std::map<std::array<int, 2>, InterfaceMatch> found;
  for_voxel_faces(tissues,
                  [&](const std::array<int, 3>& here, const std::array<int, 3>& before, std::size_t axis) {
                    const int a = tissue_at(tissues, here);
                    const int b = tissue_at(tissues, before);
                    if (a == 0 || b == 0) return;
                    InterfaceMatch& match = found[{std::min(a, b), std::max(a, b)}];
                    const double area = step[(axis + 1) % 3] * step[(axis + 2) % 3];
                    const auto covered = lines.covered[axis][tissues.voxel_index(here[0], here[1], here[2])];
                    match.map_area += area;
                    if (step[axis] - static_cast<double>(covered) <= closed) match.closed_area += area;
                  });
  for (const InterfaceFace& face : faces) {
    if (face.labels[0] == 0) continue;
    InterfaceMatch& match = found[face.labels];
    const Triangle3 t = corners_of(mesh, face);
    match.area += 0.5 * length(cross(t[1] - t[0], t[2] - t[0]));
    ++match.triangles;
  }
  std::vector<InterfaceMatch> matches;
  for (auto& [pair, match] : found) {
    match.tissues = pair;
    matches.push_back(match);
  }
  return matches;
}

/// Edges at interfaces of more than two tissues.
std::vector<Segment3> lines_of(const LabelledMesh& mesh, const std::vector<InterfaceFace>& faces) {
  std::map<std::array<Index, 2>, std::set<int>> tissues;
  for (const InterfaceFace& face : faces) {
    const auto& [a, b, c] = face.points;
    for (const auto& edge : {std::array{a, b}, std::array{a, c}, std::array{b, c}})
      tissues[edge].insert(face.labels.begin(), face.labels.end());
  }
  std::vector<Segment3> lines;
  for (const auto& [edge, around] : tissues) {
    if (around.size() < 3) continue;
    lines.push_back({mesh.mesh.points[static_cast<std::size_t>(edge[0])],
                     mesh.mesh.points[static_cast<std::size_t>(edge[1])]});
  }
  return lines;
}

}  // namespace

MapComparison compare(const Tissues& tissues, const TissueLines& map_lines, const LabelledMesh& mesh,
                      const std::vector<InterfaceFace>& faces) {
  MapComparison comparison;
  comparison.tissues.resize(static_cast<std::size_t>(tissues.count()));
  const VoxelLines lines = covered_lines(tissues, mesh);
  add_volumes(mesh, comparison.tissues);
  add_voxels(tissues, lines, comparison.tissues);
  std::vector<std::vector<Triangle3>> surfaces(comparison.tissues.size() + 1);
  for (const InterfaceFace& face : faces) {
    for (const int t : face.labels) surfaces[static_cast<std::size_t>(t)].push_back(corners_of(mesh, face));
  }
  const auto of_map = voxel_surfaces(tissues);
  for (std::size_t t = 1; t < surfaces.size(); ++t)
    comparison.tissues[t - 1].distance = distance_between(surfaces[t], of_map[t]);
  const auto of_mesh = lines_of(mesh, faces);
  const auto in_map = segments_of(map_lines);
  if (!of_mesh.empty() && !in_map.empty()) comparison.lines = distance_between(of_mesh, in_map);
  comparison.interfaces = interfaces_of(tissues, mesh, lines, faces);
  return comparison;
}

}  // namespace palpate::app

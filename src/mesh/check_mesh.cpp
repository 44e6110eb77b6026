#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

/// So that volumes, and the products of exact predicates, stay finite.
constexpr double coordinate_limit = 1e100;
/// So that not all squares of lengths underflow to 0.
constexpr double least_size = 1e-150;

/// "(1, 2, 3)", with enough digits to find the number in a file.
std::string to_text(const Vec3& p) {
  const auto number = [](double x) {
    std::string text(32, '\0');
    text.resize(static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.9g", x)));
    return text;
  };
  return "(" + number(p.x) + ", " + number(p.y) + ", " + number(p.z) + ")";
}

std::string to_text(const Tet& tet) {
  return "(" + std::to_string(tet[0]) + ", " + std::to_string(tet[1]) + ", " + std::to_string(tet[2]) + ", " +
         std::to_string(tet[3]) + ")";
}

void check_points(const TetMesh& mesh, const std::string& source) {
  if (mesh.points.empty()) throw Error(source, "", "no points", "at least 4 points");
  if (mesh.points.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw Error(source, "", std::to_string(mesh.points.size()) + " points", "at most 2147483647 points");
  }
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const Vec3& p = mesh.points[i];
    if (!(std::abs(p.x) <= coordinate_limit && std::abs(p.y) <= coordinate_limit &&
          std::abs(p.z) <= coordinate_limit)) {
      throw Error(source, "point " + std::to_string(i), "coordinates " + to_text(p),
                  is_finite(p) ? "numbers from -1e100 to 1e100" : "finite numbers");
    }
  }
}

/// Throws if the corners of a tet are not four different points of the mesh.
void check_corners(const TetMesh& mesh, std::size_t t, const std::string& source) {
  const Tet& tet = mesh.tets[t];
  const auto n = static_cast<Index>(mesh.points.size());
  const std::string where = "tet " + std::to_string(t);
  for (const Index corner : tet) {
    if (corner < 0 || corner >= n) {
      throw Error(source, where, "point index " + std::to_string(corner), "0 to " + std::to_string(n - 1));
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      if (tet[i] == tet[j]) {
        throw Error(source, where, "point " + std::to_string(tet[i]) + " twice in " + to_text(tet),
                    "four different points");
      }
    }
  }
}

/// The longest side of a box around a tet.
double longest_side(const TetMesh& mesh) {
  double longest = 0.0;
  for (const Tet& tet : mesh.tets) {
    Box box;
    for (const Index corner : tet) box.extend(at(mesh.points, corner));
    const Vec3 sides = box.upper - box.lower;
    longest = std::max({longest, sides.x, sides.y, sides.z});
  }
  return longest;
}

void check_size(const TetMesh& mesh, const std::string& source) {
  const double longest = longest_side(mesh);
  if (longest >= least_size) return;
  throw Error(source, "tets", "a size of at most " + short_number_text(longest),
              "1e-150 or more of the largest one");
}

}  // namespace

MeshNotes check_mesh(TetMesh& mesh, std::string_view source_name) {
  const std::string source(source_name);
  check_points(mesh, source);
  if (mesh.tets.empty()) throw Error(source, "", "no tets", "at least one tet");
  std::vector<bool> used(mesh.points.size(), false);
  std::vector<std::size_t> inverted;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    check_corners(mesh, t, source);
    const auto& [a, b, c, d] = mesh.tets[t];
    const int sign = orient3d(at(mesh.points, a), at(mesh.points, b), at(mesh.points, c), at(mesh.points, d));
    if (sign == 0) {
      throw Error(source, "tet " + std::to_string(t), "zero volume, points " + to_text(mesh.tets[t]),
                  "four points that are not in one plane");
    }
    if (sign < 0) inverted.push_back(t);
    for (const Index corner : mesh.tets[t]) used[static_cast<std::size_t>(corner)] = true;
  }
  check_size(mesh, source);
  for (const std::size_t t : inverted) std::swap(mesh.tets[t][2], mesh.tets[t][3]);
  MeshNotes notes;
  notes.reoriented_tets = static_cast<Index>(inverted.size());
  for (const bool u : used) notes.unreferenced_points += u ? 0 : 1;
  return notes;
}

}  // namespace palpate

#include "anatomy/fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "geometry/vector.hpp"
#include "mesh/faces.hpp"

namespace palpate::anatomy {
namespace {

/// Tets at each point.
std::vector<std::vector<Index>> tets_at_points(const TetMesh& mesh) {
  std::vector<std::vector<Index>> tets(mesh.points.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index p : mesh.tets[t]) at(tets, p).push_back(static_cast<Index>(t));
  }
  return tets;
}

/// 1 for each point of the surface.
std::vector<bool> surface_points(const TetMesh& mesh) {
  std::map<std::array<Index, 3>, int> uses;
  for (const Tet& tet : mesh.tets) {
    for (const auto& [i, j, k] : outward_face) {
      std::array<Index, 3> face{tet[i], tet[j], tet[k]};
      std::ranges::sort(face);
      ++uses[face];
    }
  }
  std::vector<bool> on_surface(mesh.points.size(), false);
  for (const auto& [face, count] : uses) {
    for (const Index p : face) {
      if (count == 1) on_surface[static_cast<std::size_t>(p)] = true;
    }
  }
  return on_surface;
}

/// The least dihedral angle of a tet in degrees; negative where the tet is flat or inverted.
double least_dihedral(const TetMesh& mesh, const Tet& tet) {
  const auto corner = [&](std::size_t i) { return at(mesh.points, tet[i]); };
  if (!(dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0)) > 0.0)) return -1.0;
  std::array<Vec3, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& [i, j, k] = outward_face[f];
    normals[f] = normalized(cross(corner(j) - corner(i), corner(k) - corner(i)));
  }
  double largest_cosine = -1.0;
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t g = 0; g < f; ++g)
      largest_cosine = std::max(largest_cosine, -dot(normals[f], normals[g]));
  }
  return std::acos(std::min(largest_cosine, 1.0)) * 180.0 / std::numbers::pi;
}

/// The step to the surface by value and gradient (Newton).
Vec3 step_to_surface(const Distance& shape, const Vec3& p) {
  constexpr double small = 1e-5;
  const auto slope = [&](const Vec3& offset) {
    return (shape(p + offset) - shape(p - offset)) / (2.0 * small);
  };
  const Vec3 gradient{slope({small, 0.0, 0.0}), slope({0.0, small, 0.0}), slope({0.0, 0.0, small})};
  const double square = squared_length(gradient);
  constexpr double least_square = 0.01;  // at creases the gradient may vanish
  return square > least_square ? (-shape(p) / square) * gradient : Vec3{};
}

/// A mesh whose points are moved one after the other.
class Fit {
 public:
  Fit(TetMesh& mesh, const Distance& shape, double least_angle)
      : mesh_(mesh),
        shape_(shape),
        least_angle_(least_angle),
        tets_(tets_at_points(mesh)),
        on_surface_(surface_points(mesh)) {}

  void sweep() {
    for (std::size_t p = 0; p < mesh_.points.size(); ++p) on_surface_[p] ? to_surface(p) : to_middle(p);
  }

 private:
  [[nodiscard]] double worst_at(std::size_t p) const {
    double worst = 180.0;
    for (const Index t : tets_[p]) worst = std::min(worst, least_dihedral(mesh_, at(mesh_.tets, t)));
    return worst;
  }
  void to_surface(std::size_t p) {
    constexpr int halvings = 3;
    const Vec3 from = mesh_.points[p];
    const Vec3 step = step_to_surface(shape_, from);
    const double allowed = std::min(least_angle_, worst_at(p));
    double fraction = 1.0;
    for (int i = 0; i <= halvings; ++i, fraction *= 0.5) {
      mesh_.points[p] = from + fraction * step;
      if (worst_at(p) >= allowed) return;
    }
    mesh_.points[p] = from;
  }
  /// Moves an inner point to the mean of its neighbours, if that improves all its tets. This makes room for
  /// points of the surface.
  void to_middle(std::size_t p) {
    const Vec3 from = mesh_.points[p];
    const double before = worst_at(p);
    Vec3 sum;
    for (const Index t : tets_[p]) {
      for (const Index q : at(mesh_.tets, t)) sum += at(mesh_.points, q);
    }
    // Each tet also counts the point itself.
    const auto count = static_cast<double>(tets_[p].size());
    mesh_.points[p] = (1.0 / (3.0 * count)) * (sum - count * from);
    if (worst_at(p) <= before) mesh_.points[p] = from;
  }

  TetMesh& mesh_;
  const Distance& shape_;
  double least_angle_;
  std::vector<std::vector<Index>> tets_;
  std::vector<bool> on_surface_;
};

}  // namespace

void fit(TetMesh& mesh, const Distance& shape, double least_angle) {
  constexpr int sweeps = 8;
  Fit points(mesh, shape, least_angle);
  for (int i = 0; i < sweeps; ++i) points.sweep();
}

TetMesh stuff_fitted(const Distance& shape, const Distance& wider, const StuffingOptions& options) {
  constexpr double least_angle = 10.0;
  TetMesh mesh = stuff(wider, options);
  fit(mesh, shape, least_angle);
  return mesh;
}

}  // namespace palpate::anatomy

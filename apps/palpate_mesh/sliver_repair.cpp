#include "sliver_repair.hpp"

#include <algorithm>
#include <limits>
#include <numbers>
#include <utility>

#include "geometry/trigonometry.hpp"
#include "geometry/vector.hpp"
#include "lattice.hpp"
#include "mesh/faces.hpp"
#include "tet_faces.hpp"

namespace palpate::app {
namespace {

/// The largest cosine of a dihedral angle of a tet: 1 where it is flat or inverted.
double largest_cosine(const std::array<Vec3, 4>& p) {
  std::array<Vec3, 4> normals;
  for (std::size_t f = 0; f < 4; ++f) {
    const auto& [a, b, c] = outward_face[f];
    normals[f] = cross(p[b] - p[a], p[c] - p[a]);
    const double area = length(normals[f]);
    if (!(area > 0.0)) return 1.0;
    normals[f] = (1.0 / area) * normals[f];
  }
  if (!(dot(normals[3], p[3] - p[0]) < 0.0)) return 1.0;
  double most = -1.0;
  for (std::size_t f = 0; f < 4; ++f) {
    for (std::size_t g = f + 1; g < 4; ++g) most = std::max(most, -dot(normals[f], normals[g]));
  }
  return std::min(most, 1.0);
}

constexpr double degree = std::numbers::pi / 180.0;

class Repairer {
 public:
  Repairer(LabelledMesh& mesh, const SliverRepair& repair)
      : mesh_(&mesh),
        bound_(cosine(repair.wanted_angle * degree)),
        at_point_(mesh.mesh.points.size()),
        room_(mesh.mesh.points.size(), std::numeric_limits<double>::infinity()),
        start_(mesh.mesh.points) {
    const auto& tets = mesh.mesh.tets;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      for (const Index p : tets[t]) at_point_[static_cast<std::size_t>(p)].push_back(t);
    }
    for (const InterfaceFace& face : interface_faces(mesh)) {
      for (const Index p : face.points) {
        const auto point = static_cast<std::size_t>(p);
        room_[point] = repair.reach(start_[point]);
      }
    }
  }

  /// The tets below the angle, the worst first.
  [[nodiscard]] std::vector<std::size_t> slivers() const {
    std::vector<std::pair<double, std::size_t>> found;
    for (std::size_t t = 0; t < mesh_->mesh.tets.size(); ++t) {
      if (const double cosine = cosine_of(t); cosine > bound_) found.emplace_back(-cosine, t);
    }
    std::ranges::sort(found);
    std::vector<std::size_t> tets;
    tets.reserve(found.size());
    for (const auto& [cosine, tet] : found) tets.push_back(tet);
    return tets;
  }

  /// Moves the corners of a tet as long as its angle grows. Returns whether any moved.
  bool improve(std::size_t tet) {
    bool moved = false;
    for (const Index p : mesh_->mesh.tets[tet]) {
      if (cosine_of(tet) <= bound_) break;
      moved = improve_point(static_cast<std::size_t>(p)) || moved;
    }
    return moved;
  }

 private:
  [[nodiscard]] double cosine_of(std::size_t tet) const {
    std::array<Vec3, 4> corners;
    for (std::size_t c = 0; c < 4; ++c)
      corners[c] = mesh_->mesh.points[static_cast<std::size_t>(mesh_->mesh.tets[tet][c])];
    return largest_cosine(corners);
  }

  [[nodiscard]] double worst_at(std::size_t point) const {
    double worst = -1.0;
    for (const std::size_t tet : at_point_[point]) worst = std::max(worst, cosine_of(tet));
    return worst;
  }

  [[nodiscard]] double shortest_edge(std::size_t point) const {
    double shortest = std::numeric_limits<double>::infinity();
    for (const std::size_t tet : at_point_[point]) {
      for (const Index other : mesh_->mesh.tets[tet]) {
        const auto there = static_cast<std::size_t>(other);
        if (there == point) continue;
        shortest = std::min(shortest, length(mesh_->mesh.points[there] - mesh_->mesh.points[point]));
      }
    }
    return shortest;
  }

  bool improve_point(std::size_t point) {
    constexpr double first_step = 0.25;  // relative to the shortest edge
    constexpr double last_step = 0.01;
    const double edge = shortest_edge(point);
    const double before = worst_at(point);
    double best = before;
    for (double step = first_step; step > last_step && best > bound_;) {
      if (!try_steps(point, step * edge, best)) step *= 0.5;
    }
    return best < before;
  }

  /// Moves a point to the best of 26 positions around it, if that is better.
  bool try_steps(std::size_t point, double step, double& best) {
    Vec3& place = mesh_->mesh.points[point];
    const Vec3 here = place;
    Vec3 chosen = here;
    for_points({3, 3, 3}, [&](int i, int j, int k) {
      const Vec3 direction{i - 1.0, j - 1.0, k - 1.0};
      if (direction == Vec3{}) return;
      place = here + (step / length(direction)) * direction;
      if (length(place - start_[point]) > room_[point]) return;
      const double worst = worst_at(point);
      if (worst < best) {
        best = worst;
        chosen = place;
      }
    });
    place = chosen;
    return chosen != here;
  }

  LabelledMesh* mesh_;
  double bound_;                                    ///< cosine of the wanted angle
  std::vector<std::vector<std::size_t>> at_point_;  ///< tets at each point
  std::vector<double> room_;                        ///< (n_points), how far a point may move from its start
  std::vector<Vec3> start_;
};

}  // namespace

double least_dihedral_angle(const std::array<Vec3, 4>& tet) {
  return arc_cosine(largest_cosine(tet)) / degree;
}

std::size_t repair_slivers(LabelledMesh& mesh, const SliverRepair& repair) {
  Repairer repairer(mesh, repair);
  for (int round = 0; round < repair.rounds; ++round) {
    bool moved = false;
    for (const std::size_t tet : repairer.slivers()) {
      if (repair.check) repair.check();
      moved = repairer.improve(tet) || moved;
    }
    if (!moved) break;
  }
  return repairer.slivers().size();
}

}  // namespace palpate::app

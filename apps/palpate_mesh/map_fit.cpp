#include "map_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "lattice.hpp"
#include "mesh/faces.hpp"
#include "sliver_repair.hpp"
#include "tet_faces.hpp"

namespace palpate::app {
namespace {

constexpr std::array<double Vec3::*, 3> component{&Vec3::x, &Vec3::y, &Vec3::z};
constexpr double samples_per_voxel = 2.0;  // along each axis
constexpr double wanted_angle = 10.0;      // degrees; no dihedral angle falls below it, or below what it was
constexpr double reach = 0.45;             // how far a point may move from where it was, in voxels
constexpr double reach_on_line = 0.25;     // the same for points on lines where three tissues meet
constexpr int most_rounds = 4;

/// The tissues at samples in a box. Sample n of an axis is at (n + 0.5) times the spacing.
class Samples {
 public:
  explicit Samples(const Tissues& tissues)
      : tissues_(&tissues), spacing_((1.0 / samples_per_voxel) * tissues.spacing()) {}

  void fill(const Box& box) {
    for (std::size_t a = 0; a < 3; ++a) {
      first_[a] = first_at(box.lower.*component[a], a);
      count_[a] = std::max(last_at(box.upper.*component[a], a) - first_[a] + 1, 0);
    }
    tissue_.clear();
    for_points(count_, [&](int i, int j, int k) {
      const Vec3 p{place(first_[0] + i, 0), place(first_[1] + j, 1), place(first_[2] + k, 2)};
      tissue_.push_back(static_cast<std::int16_t>(tissues_->at(p)));
    });
  }

  /// Number of samples of a tet without a tissue, minus the number with the tet's tissue. The sum over all
  /// tets is the number of samples with a wrong tissue, plus a constant.
  [[nodiscard]] long cost(const std::array<Vec3, 4>& tet, int tissue) const {
    std::array<Vec3, 4> normals;
    for (std::size_t f = 0; f < 4; ++f) {
      const auto& [a, b, c] = outward_face[f];
      normals[f] = cross(tet[b] - tet[a], tet[c] - tet[a]);
    }
    Box box;
    for (const Vec3& corner : tet) box.extend(corner);
    long cost = 0;
    for (int k = first_at(box.lower.z, 2); k <= last_at(box.upper.z, 2); ++k) {
      for (int j = first_at(box.lower.y, 1); j <= last_at(box.upper.y, 1); ++j) {
        double low = box.lower.x;
        double high = box.upper.x;
        for (std::size_t f = 0; f < 4; ++f) {
          const Vec3& n = normals[f];
          const Vec3& on = tet[outward_face[f][0]];
          const double off = n.y * (place(j, 1) - on.y) + n.z * (place(k, 2) - on.z);
          if (n.x > 0.0) {
            high = std::min(high, on.x - off / n.x);
          } else if (n.x < 0.0) {
            low = std::max(low, on.x - off / n.x);
          } else if (off > 0.0) {
            high = low - spacing_.x;
          }
        }
        if (!(low <= high)) continue;
        const int last = last_at(high, 0);
        for (int i = first_at(low, 0); i <= last; ++i) cost += cost_of(at(i, j, k), tissue);
      }
    }
    return cost;
  }

 private:
  [[nodiscard]] static long cost_of(int found, int tissue) {
    return (found == 0 ? 1 : 0) - (found == tissue ? 1 : 0);
  }
  [[nodiscard]] int first_at(double x, std::size_t axis) const {
    return static_cast<int>(std::ceil(x / spacing_.*component[axis] - 0.5));
  }
  [[nodiscard]] int last_at(double x, std::size_t axis) const {
    return static_cast<int>(std::floor(x / spacing_.*component[axis] - 0.5));
  }
  [[nodiscard]] double place(int n, std::size_t axis) const { return (n + 0.5) * spacing_.*component[axis]; }
  [[nodiscard]] int at(int i, int j, int k) const {
    const std::array<int, 3> v{i - first_[0], j - first_[1], k - first_[2]};
    for (std::size_t a = 0; a < 3; ++a) {
      if (v[a] < 0 || v[a] >= count_[a]) return 0;
    }
    const auto row =
        static_cast<std::size_t>(v[2]) * static_cast<std::size_t>(count_[1]) + static_cast<std::size_t>(v[1]);
    return tissue_[row * static_cast<std::size_t>(count_[0]) + static_cast<std::size_t>(v[0])];
  }

  const Tissues* tissues_;
  Vec3 spacing_;
  std::array<int, 3> first_{};
  std::array<int, 3> count_{};
  std::vector<std::int16_t> tissue_;
};

class Fitter {
 public:
  Fitter(LabelledMesh& mesh, const Tissues& tissues)
      : mesh_(&mesh),
        samples_(tissues),
        at_point_(mesh.mesh.points.size()),
        directions_(mesh.mesh.points.size()),
        reach_(mesh.mesh.points.size(), reach),
        start_(mesh.mesh.points) {
    for (const Index p : mesh.line_points) reach_[static_cast<std::size_t>(p)] = reach_on_line;
    const Vec3& s = tissues.spacing();
    voxel_ = std::cbrt(s.x * s.y * s.z);
    const auto& tets = mesh.mesh.tets;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      for (const Index p : tets[t]) at_point_[static_cast<std::size_t>(p)].push_back(t);
    }
    add_directions();
  }

  /// Moves each point of an interface once, where that helps. Returns whether a point moved.
  bool round(const std::function<void()>& check) {
    bool moved = false;
    for (std::size_t p = 0; p < at_point_.size(); ++p) {
      if (directions_[p].empty()) continue;
      if (check) check();
      moved |= improve(p);
    }
    return moved;
  }

 private:
  /// The normals of the interfaces at each point, and the axes.
  void add_directions() {
    using Pair = std::array<int, 2>;
    std::vector<std::map<Pair, Vec3>> normals(at_point_.size());
    for (const InterfaceFace& face : interface_faces(*mesh_)) {
      std::array<Vec3, 3> p;
      for (std::size_t c = 0; c < 3; ++c) p[c] = mesh_->mesh.points[static_cast<std::size_t>(face.points[c])];
      Vec3 normal = cross(p[1] - p[0], p[2] - p[0]);
      if (dot(normal, middle(face.tets[1]) - p[0]) < 0.0) normal = -1.0 * normal;
      for (const Index point : face.points) normals[static_cast<std::size_t>(point)][face.labels] += normal;
    }
    for (std::size_t p = 0; p < normals.size(); ++p) {
      auto& all = directions_[p];
      for (const auto& [pair, normal] : normals[p]) {
        if (const double size = length(normal); size > 0.0) all.push_back((1.0 / size) * normal);
      }
      if (!all.empty()) all.insert(all.end(), {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
    }
  }

  [[nodiscard]] std::array<Vec3, 4> corners(std::size_t tet) const {
    std::array<Vec3, 4> p;
    for (std::size_t c = 0; c < 4; ++c)
      p[c] = mesh_->mesh.points[static_cast<std::size_t>(mesh_->mesh.tets[tet][c])];
    return p;
  }

  [[nodiscard]] Vec3 middle(Index tet) const {
    const std::array<Vec3, 4> p = corners(static_cast<std::size_t>(tet));
    return 0.25 * (p[0] + p[1] + p[2] + p[3]);
  }

  [[nodiscard]] double least_angle_at(std::size_t point) const {
    double least = 180.0;
    for (const std::size_t t : at_point_[point]) least = std::min(least, least_dihedral_angle(corners(t)));
    return least;
  }

  [[nodiscard]] long cost_at(std::size_t point) const {
    long cost = 0;
    for (const std::size_t t : at_point_[point]) cost += samples_.cost(corners(t), mesh_->labels[t]);
    return cost;
  }

  bool improve(std::size_t point) {
    constexpr std::array<double, 3> steps{0.3, 0.15, 0.075};  // voxels
    Box box;
    for (const std::size_t t : at_point_[point]) {
      for (const Vec3& corner : corners(t)) box.extend(corner);
    }
    const double margin = steps.front() * voxel_;
    box.extend(box.lower - Vec3{margin, margin, margin});
    box.extend(box.upper + Vec3{margin, margin, margin});
    samples_.fill(box);
    const double allowed = std::min(wanted_angle, least_angle_at(point));
    Vec3& place = mesh_->mesh.points[point];
    const Vec3 here = place;
    Vec3 best_place = here;
    long best = cost_at(point);
    for (const double step : steps) {
      for (const Vec3& direction : directions_[point]) {
        for (const double sign : {-1.0, 1.0}) {
          place = here + (sign * step * voxel_) * direction;
          if (length(place - start_[point]) > reach_[point] * voxel_ || least_angle_at(point) < allowed)
            continue;
          if (const long cost = cost_at(point); cost < best) {
            best = cost;
            best_place = place;
          }
        }
      }
    }
    place = best_place;
    return best_place != here;
  }

  LabelledMesh* mesh_;
  Samples samples_;
  double voxel_ = 1.0;                              ///< mm
  std::vector<std::vector<std::size_t>> at_point_;  ///< tets at each point
  std::vector<std::vector<Vec3>> directions_;  ///< (n_points), where a point may move; none inside tissues
  std::vector<double> reach_;                  ///< (n_points), voxels
  std::vector<Vec3> start_;
};

}  // namespace

void fit_interfaces(LabelledMesh& mesh, const Tissues& tissues, const std::function<void()>& check) {
  Fitter fitter(mesh, tissues);
  for (int round = 0; round < most_rounds && fitter.round(check); ++round) continue;
}

}  // namespace palpate::app

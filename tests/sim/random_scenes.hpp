#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/simulation.hpp>

#include "geometry/rotation.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate::test {

/// A random scene: two to six boxes, balls, sheets and bars of 1 to 10 cm, one above the other, fall on a
/// fixed floor. Sizes, stiffness (20 kPa to 10 MPa, equal or different), density, Poisson's ratio, cells,
/// element quality, alignment, friction and time step (1 to 20 ms) are random. The same for both kinds of
/// elements.
class RandomScene {
 public:
  explicit RandomScene(std::uint64_t seed, ElementKind elements = ElementKind::linear)
      : elements_(elements), random_(seed) {
    aligned_ = random_.chance(0.4);
    settings.time_step = pick({0.001, 0.005, 0.01, 0.02});
    settings.response.friction = pick({0.0, 0.3, 0.8});
    model.bodies.add("floor", box_mesh({4, 4, 1}, {-floor, -floor, -0.1}, {floor, floor, 0.0}));
    model.obstacles = {1};
    model.materials = {{.young_modulus = 1e9}};
    const bool alike = random_.chance(0.5);
    const double stiffness = log_uniform(2e4, 1e7);
    const int count = random_.integer(2, 6);
    for (int i = 0; i < count; ++i) add(i, alike ? stiffness : log_uniform(2e4, 1e7));
  }

  static constexpr double floor = 0.6;  ///< half of its width, m
  Model model;
  SimulationSettings settings;

 private:
  double log_uniform(double least, double most) {
    return least * std::pow(most / least, random_.uniform(0.0, 1.0));
  }
  double pick(std::initializer_list<double> of) {
    return *(of.begin() + random_.integer(0, static_cast<int>(of.size()) - 1));
  }

  TetMesh shape() {
    const double s = log_uniform(0.01, 0.1);
    const int n = random_.integer(1, 5);
    switch (random_.integer(0, 3)) {
      case 0:
        return ball_mesh(n + 1, {}, 0.5 * s);
      case 1:
        return box_mesh({n, n, n}, {0, 0, 0}, {s, random_.uniform(0.5, 1.5) * s, s});
      case 2:
        return box_mesh({2 * n, 2 * n, 1}, {0, 0, 0}, {2 * s, 2 * s, random_.uniform(0.05, 0.2) * s});
      default:
        return box_mesh({3 * n, n, n}, {0, 0, 0}, {3 * s, s, s});
    }
  }

  /// Moves points by up to a fraction of the shortest edge, less if tets would become too flat.
  void jitter(TetMesh& mesh) {
    double shortest = 1.0;
    for (const Tet& t : mesh.tets) {
      for (std::size_t i = 1; i < 4; ++i)
        shortest = std::min(shortest, length(at(mesh.points, t[i]) - at(mesh.points, t[0])));
    }
    const auto six_volumes = [](const std::vector<Vec3>& points, const Tet& t) {
      return dot(cross(at(points, t[1]) - at(points, t[0]), at(points, t[2]) - at(points, t[0])),
                 at(points, t[3]) - at(points, t[0]));
    };
    double by = random_.uniform(0.05, 0.3) * shortest;
    for (int attempt = 0; attempt < 20; ++attempt, by *= 0.8) {
      std::vector<Vec3> moved = mesh.points;
      for (Vec3& p : moved) p += random_.point(-by, by);
      const bool good = std::ranges::all_of(mesh.tets, [&](const Tet& t) {
        return six_volumes(moved, t) > 0.05 * six_volumes(mesh.points, t);
      });
      if (!good) continue;
      mesh.points = moved;
      return;
    }
  }

  void add(int number, double stiffness) {
    TetMesh mesh = shape();
    if (random_.chance(0.5)) jitter(mesh);
    if (!aligned_) {
      const Vec3 axis = random_.point(-1.0, 1.0);
      const Quaternion rotation = quaternion_of({random_.uniform(-1.0, 1.0), axis.x, axis.y, axis.z});
      for (Vec3& p : mesh.points) p = rotated(rotation, p);
    }
    Vec3 lower = mesh.points.front();
    Vec3 upper = lower;
    for (const Vec3& p : mesh.points) {
      lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
    const bool centred = aligned_ && random_.chance(0.5);
    const auto aside = [&](double size) { return centred ? 0.0 : random_.uniform(-0.3, 0.3) * size; };
    const Vec3 middle = 0.5 * (lower + upper);
    const Vec3 move{aside(upper.x - lower.x) - middle.x, aside(upper.y - lower.y) - middle.y,
                    top_ + random_.uniform(1e-4, 5e-3) - lower.z};
    for (Vec3& p : mesh.points) p += move;
    top_ = upper.z + move.z;
    model.bodies.add("body " + std::to_string(number), std::move(mesh));
    model.obstacles.push_back(0);
    model.materials.push_back({.young_modulus = stiffness,
                               .poisson_ratio = random_.uniform(0.2, 0.49),
                               .density = log_uniform(500.0, 2000.0),
                               .elements = elements_});
  }

  ElementKind elements_;
  Random random_;
  bool aligned_ = false;
  double top_ = 0.0;
};

}  // namespace palpate::test

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_path.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

/// Shots of one body at another, and a test whether one went through.
namespace palpate::test {

/// A body centred at the origin, and the fraction of it along each axis that is its core.
struct ShotBody {
  std::string name;
  TetMesh mesh;
  Vec3 core;
  double thickness = 0.0;  ///< m
};

inline ShotBody random_shot_body(Random& random) {
  switch (random.integer(0, 3)) {
    case 0: {
      const double r = random.uniform(0.01, 0.03);
      return {"ball", ball_mesh(random.integer(2, 3), {}, r), {0.5, 0.5, 0.5}, r};
    }
    case 1: {
      const double half = 0.5 * random.uniform(0.0005, 0.005);
      const double side = random.uniform(0.02, 0.05);
      return {"sheet",
              box_mesh({random.integer(2, 4), random.integer(2, 4), 1}, {-side, -side, -half},
                       {side, side, half}),
              {0.8, 0.8, 0.5},
              2.0 * half};
    }
    case 2: {
      const double half = 0.5 * random.uniform(0.001, 0.003);
      const double side = random.uniform(0.02, 0.04);
      return {"needle",
              box_mesh({random.integer(4, 8), 1, 1}, {-side, -half, -half}, {side, half, half}),
              {0.8, 0.5, 0.5},
              2.0 * half};
    }
    default: {
      const double s = random.uniform(0.01, 0.03);
      TetMesh mesh{{{-s, -s, -s}, {s, s, -s}, {s, -s, s}, {-s, s, s}}, {{0, 1, 2, 3}}};
      for (Vec3& p : mesh.points) p += random.point(-0.2 * s, 0.2 * s);
      return {"tet", mesh, {0.4, 0.4, 0.4}, s};
    }
  }
}

/// The inner part of a body, which moves with its tissue.
class Core {
 public:
  /// \param rest  points of the mesh where the simulation has them at rest
  Core(const Bodies& bodies, Index body, const Vec3& part, const TetMesh& about_origin) : bodies_(bodies) {
    const Body& b = at(bodies.bodies(), body);
    Vec3 middle;
    for (const Vec3& p : about_origin.points)
      middle += (1.0 / static_cast<double>(about_origin.points.size())) * p;
    for (Index p = b.points.begin; p < b.points.end; ++p) {
      const Vec3 d = at(about_origin.points, p - b.points.begin) - middle;
      places_.push_back(place_of(about_origin, b, middle + Vec3{part.x * d.x, part.y * d.y, part.z * d.z}));
    }
    for (Index t = b.triangles.begin; t < b.triangles.end; ++t) {
      Triangle corners = at(bodies.triangles(), t);
      for (Index& corner : corners) corner -= b.points.begin;
      triangles_.push_back(corners);
    }
  }
  /// Sets its points at a time between two positions of the body.
  void put(std::span<const Vec3> start, std::span<const Vec3> end, double time) {
    points_.clear();
    for (const auto& [tet, weights] : places_) {
      Vec3 sum;
      for (std::size_t i = 0; i < 4; ++i) {
        const Index p = at(bodies_.tets(), tet)[i];
        sum += weights[i] * (at(start, p) + time * (at(end, p) - at(start, p)));
      }
      points_.push_back(sum);
    }
  }
  [[nodiscard]] Box box() const {
    Box box;
    for (const Vec3& p : points_) box.extend(p);
    return box;
  }
  /// Places where an edge of one crosses the surface of the other at the set positions.
  [[nodiscard]] std::vector<Vec3> crossings(const Core& other) const {
    std::vector<Vec3> places;
    pierce(other, places);
    other.pierce(*this, places);
    return places;
  }

 private:
  struct Place {
    Index tet;
    std::array<double, 4> weights;
  };
  Place place_of(const TetMesh& mesh, const Body& b, const Vec3& p) const {
    for (Index t = b.tets.begin; t < b.tets.end; ++t) {
      std::array<Vec3, 4> x;
      for (std::size_t i = 0; i < 4; ++i) x[i] = at(mesh.points, at(bodies_.tets(), t)[i] - b.points.begin);
      if (point_in_tet(p, x[0], x[1], x[2], x[3])) return {t, barycentric_weights(p, x[0], x[1], x[2], x[3])};
    }
    return {b.tets.begin, {0.25, 0.25, 0.25, 0.25}};
  }
  void pierce(const Core& other, std::vector<Vec3>& places) const {
    const Box whole = other.box();
    for (const Triangle& t : triangles_) {
      for (std::size_t c = 0; c < 3; ++c) {
        const Vec3& a = at(points_, t[c]);
        const Vec3& b = at(points_, t[(c + 1) % 3]);
        Box edge;
        edge.extend(a);
        edge.extend(b);
        if (t[c] > t[(c + 1) % 3] || !edge.overlaps(whole)) continue;
        for (const Triangle& o : other.triangles_) {
          const std::array<Vec3, 3> x{at(other.points_, o[0]), at(other.points_, o[1]),
                                      at(other.points_, o[2])};
          if (!segment_meets_triangle(a, b, x[0], x[1], x[2])) continue;
          const Vec3 normal = cross(x[1] - x[0], x[2] - x[0]);
          const double height = dot(normal, a - x[0]);
          const double change = height - dot(normal, b - x[0]);
          places.push_back(a + (change != 0.0 ? std::clamp(height / change, 0.0, 1.0) : 0.5) * (b - a));
        }
      }
    }
  }

  const Bodies& bodies_;
  std::vector<Place> places_;
  std::vector<Triangle> triangles_;
  std::vector<Vec3> points_;
};

/// Whether the surface of a body encloses a place at a time between two positions: its winding number there
/// (sum of the solid angles of its triangles) is not zero. Where tissue is turned inside out it may lie
/// outside of the surface.
inline bool encloses(const Bodies& bodies, Index body, std::span<const Vec3> start, std::span<const Vec3> end,
                     double time, const Vec3& place) {
  constexpr double pi = 3.14159265358979323846;
  const Range& triangles = at(bodies.bodies(), body).triangles;
  double angles = 0.0;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    std::array<Vec3, 3> x;
    for (std::size_t i = 0; i < 3; ++i) {
      const Index p = at(bodies.triangles(), t)[i];
      x[i] = at(start, p) + time * (at(end, p) - at(start, p)) - place;
    }
    const std::array<double, 3> l{length(x[0]), length(x[1]), length(x[2])};
    angles +=
        2.0 * std::atan2(dot(x[0], cross(x[1], x[2])), l[0] * l[1] * l[2] + dot(x[0], x[1]) * l[2] +
                                                           dot(x[1], x[2]) * l[0] + dot(x[2], x[0]) * l[1]);
  }
  return std::abs(angles) > 2.0 * pi;
}

/// A random shot: projectile, target and speed.
struct Shot {
  std::array<ShotBody, 2> bodies;  ///< target, projectile
  std::string name;
  bool obstacle = false;
  double motion = 0.0;  ///< of the projectile in a step, over the smaller thickness
  Model model;
  int steps = 0;
  double time_step = 0.01;  ///< s
};

inline Shot random_shot(std::uint64_t seed) {
  Random random(seed);
  Shot shot;
  shot.bodies = {random_shot_body(random), random_shot_body(random)};
  const double thin = std::min(shot.bodies[0].thickness, shot.bodies[1].thickness);
  shot.motion = 0.2 * std::pow(250.0, random.uniform(0.0, 1.0));
  shot.obstacle = random.chance(0.5);
  const Vec3 direction = normalized(random.chance(0.4) ? Vec3{0.01, 0.02, -1.0} : random.point(-1, 1));
  const double size = 0.06;
  const double speed = shot.motion * thin / shot.time_step;
  const Vec3 aside = random.chance(0.5) ? Vec3{} : random.point(-0.02, 0.02);
  const double before = (2.0 * size + random.uniform(0.0, 1.0) * speed * shot.time_step);
  const Vec3 axis = random.point(-1, 1);
  const double angle = random.chance(0.5) ? 0.0 : random.uniform(-3, 3);
  const Vec3 spin = random.chance(0.5) ? Vec3{} : 0.3 * speed / size * random.point(-1, 1);
  for (std::size_t b = 0; b < 2; ++b) {
    TetMesh mesh = shot.bodies[b].mesh;
    for (Vec3& p : mesh.points) {
      if (b == 1) p = rotated(p, axis, angle) + aside - before * direction;
      shot.model.velocities.push_back(
          b == 1 ? speed * direction + cross(spin, p - (aside - before * direction)) : Vec3{});
    }
    shot.model.bodies.add(shot.bodies[b].name, std::move(mesh));
    Material material;
    material.young_modulus = 1e5;
    shot.model.materials.push_back(material);
  }
  shot.model.obstacles = {static_cast<std::uint8_t>(shot.obstacle ? 1 : 0), 0};
  shot.steps = std::min(static_cast<int>((before + 2.0 * size) / (speed * shot.time_step)) + 4, 120);
  shot.name = shot.bodies[1].name + " at " + shot.bodies[0].name + (shot.obstacle ? " (fixed)" : "") + ", " +
              std::to_string(shot.motion) + " thicknesses a step, seed " + std::to_string(seed);
  return shot;
}

/// The same shot with a time step of 1 to 20 ms and Young's moduli of 1 kPa to 100 MPa; the motion in a step
/// is that of before. Bodies are not softer than E = density x speed^2, so that waves in them are at least as
/// fast as the shot. Faster shots crush them.
inline Shot random_shot_of_any_tissue(std::uint64_t seed) {
  Shot shot = random_shot(seed);
  Random random(seed + 0x9e3779b97f4a7c15U);
  const double before = shot.time_step;
  shot.time_step = 0.001 * std::pow(20.0, random.uniform(0.0, 1.0));
  for (Vec3& velocity : shot.model.velocities) velocity = (before / shot.time_step) * velocity;
  shot.name += ", h " + std::to_string(1e3 * shot.time_step) + " ms, E";
  const double speed =
      shot.motion * std::min(shot.bodies[0].thickness, shot.bodies[1].thickness) / shot.time_step;
  for (Material& material : shot.model.materials) {
    material.young_modulus =
        std::max(std::pow(10.0, random.uniform(3.0, 8.0)), material.density * speed * speed);
    shot.name += " " + std::to_string(1e-3 * material.young_modulus) + " kPa";
  }
  return shot;
}

struct ShotResult {
  bool went_through = false;
  bool creeps =
      false;  ///< it went through in steps too slow for the swept search: edge contacts must stop it
  bool turned = false;           ///< it went through where a body was turned inside out: see is_turned()
  bool leaves_its_body = false;  ///< a core crossed another outside of one of the bodies: not a pass
  bool blew_up = false;          ///< faster than five times the speed of the shot: not caused by a hit
  int through_step = 0;
  std::int64_t stopped = 0;
  std::int64_t passes = 0;
  int most_solves = 0;
};

/// Whether a body has a negative volume: its tissue is crushed, what is inside of it is not defined, and
/// metrics count inverted tets.
inline bool is_turned(const Bodies& bodies, const Body& body, std::span<const Vec3> positions) {
  double sum = 0.0;
  for (Index t = body.tets.begin; t < body.tets.end; ++t) {
    const Tet& tet = at(bodies.tets(), t);
    const Vec3& a = at(positions, tet[0]);
    sum += dot(cross(at(positions, tet[1]) - a, at(positions, tet[2]) - a), at(positions, tet[3]) - a);
  }
  return sum < 0.0;
}

/// Whether two cores cross on a straight path, in places that both bodies enclose, and whether in others.
inline std::pair<bool, bool> cross_on_path(std::array<Core, 2>& cores, const Bodies& bodies,
                                           std::span<const Vec3> start, std::span<const Vec3> end,
                                           double thin) {
  std::pair<bool, bool> result{false, false};
  double motion = 0.0;
  std::array<Box, 2> boxes;
  for (std::size_t p = 0; p < start.size(); ++p) {
    motion = std::max(motion, length(end[p] - start[p]));
    Box& box = at(boxes, bodies.body_of_point()[p]);
    box.extend(start[p]);
    box.extend(end[p]);
  }
  if (!boxes[0].overlaps(boxes[1])) return result;
  const int checks = std::min(static_cast<int>(2.0 * motion / (0.1 * thin)) + 1, 1500);
  for (int i = 1; i <= checks && !result.first; ++i) {
    const double time = static_cast<double>(i) / checks;
    for (Core& core : cores) core.put(start, end, time);
    if (!cores[0].box().overlaps(cores[1].box())) continue;
    for (const Vec3& place : cores[0].crossings(cores[1])) {
      const auto enclosed = [&](Index body) {
        const double d = 0.05 * thin;
        return std::ranges::all_of(
            std::array<Vec3, 6>{{{d, 0, 0}, {-d, 0, 0}, {0, d, 0}, {0, -d, 0}, {0, 0, d}, {0, 0, -d}}},
            [&](const Vec3& by) { return encloses(bodies, body, start, end, time, place + by); });
      };
      (enclosed(0) && enclosed(1) ? result.first : result.second) = true;
    }
  }
  return result;
}

/// Whether the cores of the bodies ever cross at a place that both bodies enclose, also if it is displaced by
/// 5 % of a thickness. (In a body that is crushed or folded sharply, parts of the core lie at the surface or
/// outside of it.) A substep is a straight path; it is sampled so often that relative motion between two
/// samples is at most a tenth of a thickness.
inline ShotResult shoot(const Shot& shot, ContinuousDetection continuous) {
  SimulationSettings settings;
  settings.time_step = shot.time_step;
  settings.gravity = {};
  settings.detection.continuous = continuous;
  Simulation simulation(shot.model, settings, 1);
  const Bodies& bodies = simulation.bodies();
  std::array<Core, 2> cores{Core(bodies, 0, shot.bodies[0].core, shot.bodies[0].mesh),
                            Core(bodies, 1, shot.bodies[1].core, shot.bodies[1].mesh)};
  ShotResult result;
  const double thin = std::min(shot.bodies[0].thickness, shot.bodies[1].thickness);
  std::vector<Vec3> start;
  const double speed = simulation.metrics().largest_speed;
  SimulationPath::record(simulation);
  for (int step = 0; step < shot.steps && !result.went_through; ++step) {
    start.assign(simulation.positions().begin(), simulation.positions().end());
    const StepMetrics& m = simulation.step();
    result.blew_up = m.largest_speed > 5.0 * speed;
    if (result.blew_up) break;
    result.stopped += m.stopped_passes;
    result.passes += m.passes;
    result.most_solves = std::max(result.most_solves, m.solves);
    for (const std::vector<Vec3>& end : SimulationPath::of_last_step(simulation)) {
      const auto [crosses, outside] = cross_on_path(cores, bodies, start, end, thin);
      result.leaves_its_body = result.leaves_its_body || outside;
      result.went_through = crosses;
      result.turned = crosses && m.inverted_tets > 0 &&
                      std::ranges::any_of(bodies.bodies(),
                                          [&](const Body& body) { return is_turned(bodies, body, end); });
      if (crosses) break;
      start = end;
    }
    result.creeps = result.went_through && m.pairs_that_could_pass == 0;
    result.through_step = step + 1;
  }
  return result;
}

/// Numbers of outcomes of shots.
struct Shots {
  int through = 0;
  int turned = 0;  ///< went through, but turned inside out
  int unseen = 0;  ///< of those that went through and are not turned, without a pass that was counted
  int creeps = 0;
  int blown_up = 0;
};

/// Shots with these seeds; names those that went through or blew up.
inline Shots shoot_all(std::uint64_t first, int count, ContinuousDetection continuous,
                       Shot (*shot_of)(std::uint64_t) = random_shot) {
  Shots shots;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
    const Shot shot = shot_of(seed);
    try {
      const ShotResult result = shoot(shot, continuous);
      const bool through = result.went_through && !result.creeps && !result.turned;
      shots.turned += result.turned ? 1 : 0;
      if (result.turned) std::printf("turned inside out, and ");
      if (through || result.turned)
        std::printf("through in step %d: %s\n", result.through_step, shot.name.c_str());
      shots.through += through ? 1 : 0;
      shots.unseen += through && result.passes == 0 ? 1 : 0;
      shots.creeps += result.creeps ? 1 : 0;
      if (result.blew_up) std::printf("blew up: %s\n", shot.name.c_str());
      shots.blown_up += result.blew_up ? 1 : 0;
    } catch (const Error& error) {
      std::printf("blew up: %s: %s\n", shot.name.c_str(), error.what());
      ++shots.blown_up;
    }
  }
  std::printf(
      "%d shots: %d went through (%d without a pass that was counted), %d turned inside out and went "
      "through, "
      "%d crept through below the filter, %d blew up\n",
      count, shots.through, shots.unseen, shots.turned, shots.creeps, shots.blown_up);
  return shots;
}

}  // namespace palpate::test

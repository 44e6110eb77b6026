#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/model.hpp>

#include "fem/external_forces.hpp"

namespace palpate {

/// Loads on points and surfaces.
struct LoadSet {
  std::vector<Vec3> forces;       ///< (n_points), N, or empty
  std::vector<double> pressures;  ///< (n_triangles), Pa, or empty
  std::vector<PointLoad> points;
  std::vector<SurfaceLoad> surfaces;
  std::vector<std::optional<Vec3>> gravity;  ///< (n_bodies) or empty
};
/// The loads of a model.
[[nodiscard]] LoadSet loads_of(const Model& model);
/// Replaces all loads of a body. Throws Error on a body out of range, and if a load of this body also
/// belongs to another body.
void replace_loads(const BodyLoads& change, const Bodies& bodies, LoadSet& loads);

/// Computes the forces on points in each step, from loads on points and surfaces and from the gravity of
/// single bodies.
class Loads {
 public:
  /// Throws Error naming the load: arrays whose length does not match the bodies, an index out of range, a
  /// triangle of a rigid body or named twice, a number that is not finite, times of a ramp that do not grow.
  /// \param obstacles  (n_bodies) 1: rigid
  /// \param ambient    (n_bodies) 1: can have an ambient pressure (fem::ExternalForces)
  /// \param free       (n_points) 1: not held; must outlive this
  /// \param masses     (n_points), kg; must outlive this
  Loads(LoadSet loads, const Bodies& bodies, std::span<const std::uint8_t> obstacles,
        std::vector<std::uint8_t> ambient, std::span<const std::uint8_t> free,
        std::span<const double> masses);

  /// Replace the loads. They throw Error as Simulation's functions of the same names do.
  void set_forces(std::span<const Index> points, std::span<const Vec3> forces);
  void set_pressure(const Bodies& bodies, std::span<const Index> triangles, double pressure);
  void set_pressure(const Bodies& bodies, std::span<const Index> triangles,
                    std::span<const double> pressures);

  /// Whether there are pressures: forces() depends on positions.
  [[nodiscard]] bool presses() const;
  /// Forces on points in a step (n_points x 3), N; empty without loads. Ramps are evaluated at the end of the
  /// step, since it is implicit. If pressures of one sign act on all surface triangles of a body that can
  /// have an ambient pressure, the least of them is its ambient pressure, and only what others exceed it by
  /// is in the forces. Triangles with all corners held do not count: there it only changes what holds them.
  /// Valid until the next call. O(points + triangles), O(1) with forces on points only.
  fem::ExternalForces forces(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& gravity,
                             double time_end);

  /// The current loads: part of the saved state.
  [[nodiscard]] const LoadSet& all() const { return loads_; }
  /// Time from which on no ramp changes, s; 0 without ramps. O(loads).
  [[nodiscard]] double end() const;
  void restore(std::vector<Vec3> forces, std::vector<double> pressures);

 private:
  void add_surface_load(const SurfaceLoad& load, const Bodies& bodies, double time);
  void sum_pressures(const Bodies& bodies, double time);
  [[nodiscard]] double common_pressure(const Bodies& bodies, const Range& triangles) const;
  void add_pressures(const Bodies& bodies, std::span<const Vec3> positions, double time);

  std::vector<std::uint8_t> rigid_;          ///< (n_bodies)
  std::vector<std::uint8_t> takes_ambient_;  ///< (n_bodies)
  std::span<const std::uint8_t> free_;       ///< (n_points)
  std::span<const double> masses_;
  LoadSet loads_;
  std::vector<Vec3> sum_;                     ///< (n_points) forces of the current step
  std::vector<Vec3> turning_;                 ///< (n_points) those of them that pressures make, or empty
  std::vector<double> pressure_of_triangle_;  ///< (n_triangles) of the current step, Pa
  std::vector<double> ambient_;               ///< (n_bodies) of the current step, Pa, or empty
};

/// Factor of a ramp at a time. O(times).
[[nodiscard]] double factor_at(const Ramp& ramp, double time);
/// Time from which on the factor of a ramp does not change, s. O(times).
[[nodiscard]] double end_of(const Ramp& ramp);

}  // namespace palpate

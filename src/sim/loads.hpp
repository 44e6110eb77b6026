#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/model.hpp>

namespace palpate {

/// The loads on points and surfaces, and gravity of single bodies: forces on points, step by step.
class Loads {
 public:
  /// Takes the loads of a model. Throws Error naming the load: arrays of another length than the bodies have,
  /// an index out of range, a triangle of a rigid body or named twice, a number that is not finite, times of
  /// a ramp that do not grow.
  /// \param bodies     those of the model, which may have handed them on
  /// \param obstacles  (n_bodies) 1: rigid
  /// \param masses     (n_points), kg; must outlive this
  Loads(const Model& model, const Bodies& bodies, std::span<const std::uint8_t> obstacles,
        std::span<const double> masses);

  /// In place of what they were; Simulation's functions of the same names say what is refused.
  void set_forces(std::span<const Index> points, std::span<const Vec3> forces);
  void set_pressure(const Bodies& bodies, std::span<const Index> triangles, double pressure);

  /// Forces of a step on points at the positions at its start (n_points x 3), N, or empty: none. Factors of
  /// ramps are those of its end, as the step is implicit. Valid until the next call.
  /// O(points + loaded triangles), O(1) where forces on points are all there is.
  std::span<const Vec3> forces(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& gravity,
                               double time_end);

  /// What was set besides the model: part of the state that a resumed run needs.
  [[nodiscard]] const std::vector<Vec3>& point_forces() const { return forces_; }
  [[nodiscard]] const std::vector<double>& pressures() const { return pressures_; }
  void restore(std::vector<Vec3> forces, std::vector<double> pressures);

 private:
  void add_surface_load(const SurfaceLoad& load, const Bodies& bodies, std::span<const Vec3> positions,
                        double time);

  std::vector<std::uint8_t> rigid_;  ///< (n_bodies)
  std::span<const double> masses_;
  std::vector<Vec3> forces_;       ///< (n_points), N, or empty
  std::vector<double> pressures_;  ///< (n_triangles), Pa, or empty
  std::vector<PointLoad> point_loads_;
  std::vector<SurfaceLoad> surface_loads_;
  std::vector<std::optional<Vec3>> gravity_;  ///< (n_bodies) or empty
  std::vector<Vec3> sum_;                     ///< (n_points), of a step
};

/// Factor of a ramp at a time. O(times).
[[nodiscard]] double factor_at(const Ramp& ramp, double time);

}  // namespace palpate

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>

namespace palpate::view {

/// How hard a point of tissue may be pulled; a hand that pulls harder turns tets inside out, or throws bodies
/// about. The least of
/// - what stretches the tissue around the point by about a third of its own size: largest_strain times a
/// third of
///   Young's modulus times area, of the surface triangles there or, at corners less, of the faces opposite
///   the point in its tets,
/// - what presses the whole body into the softest that lies against it (their boxes meet): largest_squeeze
///   times Young's modulus of that times a quarter of the body's surface, a ball's cross-section,
/// - for a body that nothing holds (no point fixed, on rails or tied), what moves all of it by largest_leap
/// mean
///   edges within a time step from rest.
class PullLimits {
 public:
  static constexpr double largest_strain = 0.3;
  static constexpr double largest_squeeze = 0.1;
  static constexpr double largest_leap = 0.2;  ///< as what is on rails follows a hand

  /// \param of_bodies  (n_bodies) mean material of each
  /// \param edges      (n_bodies) mean length of an edge
  /// O(points + triangles + tets + bodies^2).
  PullLimits(const Model& model, std::span<const Material> of_bodies, std::span<const double> edges,
             double time_step);

  /// The largest force of a pull, in the unit of the scene; 0 at a point inside.
  [[nodiscard]] double force(Index point) const { return forces_[static_cast<std::size_t>(point)]; }

 private:
  std::vector<double> forces_;  ///< (n_points)
};

/// The stiffness of a spring that pulls no harder than `most` at the start of a step, where the point is, and
/// at its end, where it is going: `stiffness`, or less. The spring gives way, in place of its target: so a
/// hand far away pulls with `most` all through a step. \param going  the way of the point in a step at its
/// velocity
[[nodiscard]] double limited_stiffness(const Vec3& point, const Vec3& going, const Vec3& target,
                                       double stiffness, double most);

}  // namespace palpate::view

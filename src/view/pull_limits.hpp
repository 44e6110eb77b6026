#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/model.hpp>

namespace palpate::view {

/// How hard a point of tissue may be pulled; a hand that pulls harder turns tets inside out. The lesser of
/// - what stretches the tissue around the point by about a third of its own size: largest_strain times
///   Young's modulus times a third of the area at rest of the surface triangles there,
/// - what presses the whole body into the softest that lies against it (their boxes meet): largest_squeeze
///   times Young's modulus of that times a quarter of the body's surface, a ball's cross-section.
class PullLimits {
 public:
  static constexpr double largest_strain = 0.3;
  static constexpr double largest_squeeze = 0.1;

  /// \param rigid  (n_bodies) 1: a body that does not deform; empty: none. O(points + triangles + bodies^2).
  PullLimits(const Bodies& bodies, std::span<const Material> materials, std::span<const std::uint8_t> rigid);

  /// The largest force of a pull, in the unit of the scene; 0 at a point inside.
  [[nodiscard]] double force(Index point) const { return forces_[static_cast<std::size_t>(point)]; }

 private:
  std::vector<double> forces_;  ///< (n_points)
};

/// The stiffness of a spring that pulls no harder than `most` from where the point is: `stiffness`, or less.
/// The spring gives way, in place of its target: so a hand far away pulls with `most` all through a step.
[[nodiscard]] double limited_stiffness(const Vec3& point, const Vec3& target, double stiffness, double most);

}  // namespace palpate::view

#pragma once

#include <span>
#include <vector>

#include <palpate/model.hpp>

namespace palpate::view {

/// How hard a point of tissue may be pulled: what stretches the tissue around it by about its own size. A
/// point carries a third of the surface triangles around it; their area at rest times Young's modulus times
/// largest_strain is the limit. A hand that pulls harder turns tets inside out.
class PullLimits {
 public:
  static constexpr double largest_strain = 0.5;

  /// \param materials  (n_bodies) with Young's modulus. O(points + triangles).
  PullLimits(const Bodies& bodies, std::span<const Material> materials);

  /// The largest force of a pull, in the unit of the scene; 0 at a point inside.
  [[nodiscard]] double force(Index point) const { return forces_[static_cast<std::size_t>(point)]; }

 private:
  std::vector<double> forces_;  ///< (n_points)
};

/// The stiffness of a spring that pulls no harder than `most` from where the point is: `stiffness`, or less.
/// The spring gives way, in place of its target: so a hand far away pulls with `most` all through a step.
[[nodiscard]] double limited_stiffness(const Vec3& point, const Vec3& target, double stiffness, double most);

}  // namespace palpate::view

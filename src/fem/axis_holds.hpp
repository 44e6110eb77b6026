#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "fem/coupling.hpp"
#include "fem/lumping.hpp"
#include "simd/padded.hpp"

namespace palpate::fem {

/// Axes of the world as bits of a number.
inline constexpr std::uint8_t all_axes = 7;
[[nodiscard]] constexpr bool has_axis(std::uint8_t axes, int axis) {
  return ((axes >> axis) & 1) != 0;
}
/// The components of a vector along these axes; the other components become zero.
[[nodiscard]] constexpr Vec3 along(std::uint8_t axes, const Vec3& v) {
  return {has_axis(axes, 0) ? v.x : 0.0, has_axis(axes, 1) ? v.y : 0.0, has_axis(axes, 2) ? v.z : 0.0};
}

/// Free points that do not move along some axes of the world: rollers, planes of symmetry.
///
/// In the linear system of a step, each held axis is a damper, 1e5 times as stiff as the rest of its row.
/// Block Jacobi eliminates it exactly. The right side has no force along the axis, since the constraint
/// carries that force. So a body at rest does not creep. After a solve the motion along the axis is set to
/// zero. An error remains in neighbouring rows: 1e-5 of the CHANGE of the holding force, so zero at rest.
class AxisHolds {
 public:
  AxisHolds() = default;
  /// \param axes  (n_points) bits, or empty. Ignored at points that are not free or are held along all axes
  /// \param free  (n_points) 1: moves
  ///
  /// O(n_points + tets at held points).
  AxisHolds(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> axes,
            std::span<const std::uint8_t> free, std::span<const double> masses);

  [[nodiscard]] bool any() const { return !holds_.empty(); }
  /// The dampers of a step of this length, one for each point, ascending.
  void append(double time_step, std::vector<Coupling>& couplings) const;
  /// Sets the right side along held axes so that the points come to rest.
  /// \param base  velocity to which the solution is added
  void hold(double time_step, std::span<const simd::Padded3> base, std::span<simd::Padded3> right_side) const;
  /// Sets the components along held axes to zero.
  void stop(std::span<Vec3> values) const;
  /// Sets the components along held axes to zero; or, if `base` is given, to the negative of `base`.
  void stop(std::span<const simd::Padded3> base, std::span<simd::Padded3> values) const;
  /// Copies the components along held axes from other values. So positions along these axes keep all bits.
  void keep(std::span<const Vec3> from, std::span<Vec3> values) const;
  /// Sets the bits of these points.
  void mark(std::span<std::uint8_t> axes_of_point) const;

 private:
  struct Hold {
    Index point = -1;
    std::uint8_t axes = 0;
    double mass = 0.0;       ///< kg
    double stiffness = 0.0;  ///< of its row at rest, N/m
    double damping = 0.0;    ///< of its row at rest, N s/m
  };
  [[nodiscard]] static double coefficient(const Hold& hold, double time_step);

  std::vector<Hold> holds_;
};

}  // namespace palpate::fem

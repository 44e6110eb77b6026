#include "fem/axis_holds.hpp"

#include <array>

#include "fem/viscosity.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

/// Stiffness of the damper, as a multiple of the rest of its row: the smallest one whose error is below the
/// tolerance of the solver, so that floats lose few digits.
constexpr double excess = 1e5;

/// Squared gradient of the shape function of a corner at rest, 1/m^2. It is 1 / height^2, with the height of
/// the corner over the opposite face.
double squared_gradient(const std::array<Vec3, 4>& corners, std::size_t corner) {
  const Vec3& a = corners[(corner + 1) % 4];
  const Vec3 normal = cross(corners[(corner + 2) % 4] - a, corners[(corner + 3) % 4] - a);
  const double six_volumes = dot(normal, corners[corner] - a);
  return squared_length(normal) / (six_volumes * six_volumes);
}

/// Reference to a component of a Vec3 or a Padded3.
template <class Vector>
auto& component_of(Vector& v, int axis) {
  if (axis == 0) return v.x;
  return axis == 1 ? v.y : v.z;
}

/// Calls f(axis) for each axis.
template <class F>
void for_axes(std::uint8_t axes, F&& f) {
  for (int axis = 0; axis < 3; ++axis) {
    if (has_axis(axes, axis)) f(axis);
  }
}

}  // namespace

AxisHolds::AxisHolds(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> axes,
                     std::span<const std::uint8_t> free, std::span<const double> masses) {
  for (std::size_t p = 0; p < axes.size(); ++p) {
    if (axes[p] == 0 || free[p] == 0) continue;
    Hold hold{.point = static_cast<Index>(p), .axes = axes[p], .mass = masses[p]};
    for (const Index tet : bodies.point_tets()[hold.point]) {
      const Tet& points = at(bodies.tets(), tet);
      std::array<Vec3, 4> corners;
      std::size_t own = 0;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = at(bodies.points_rest(), points[k]);
        if (points[k] == hold.point) own = k;
      }
      const Material& m = materials.of(tet, at(bodies.body_of_point(), hold.point));
      const double nu = m.poisson_ratio;
      // The P-wave modulus, lambda + 2 mu.
      const double modulus = instantaneous_modulus(m) * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
      const double tet_stiffness = modulus * tet_volume_rest(bodies, tet) * squared_gradient(corners, own);
      hold.stiffness += tet_stiffness;
      hold.damping += m.stiffness_damping * tet_stiffness;
    }
    holds_.push_back(hold);
  }
}

/// Viscous part of the row, N s/m.
double AxisHolds::coefficient(const Hold& hold, double time_step) {
  return excess * (hold.mass / time_step + time_step * hold.stiffness + hold.damping);
}

void AxisHolds::append(double time_step, std::vector<Coupling>& couplings) const {
  for (const Hold& hold : holds_) {
    const double c = coefficient(hold, time_step);
    const Vec3 diagonal = along(hold.axes, {c, c, c});
    Coupling& coupling = couplings.emplace_back();
    coupling.points[0] = hold.point;
    coupling.coefficients[0] = 1.0;
    coupling.damping = {diagonal.x, diagonal.y, diagonal.z, 0.0, 0.0, 0.0};
  }
}

void AxisHolds::hold(double time_step, std::span<const simd::Padded3> base,
                     std::span<simd::Padded3> right_side) const {
  for (const Hold& hold : holds_) {
    const double weight = time_step * coefficient(hold, time_step);
    for_axes(hold.axes, [&](int axis) {
      component_of(at(right_side, hold.point), axis) = -weight * component_of(at(base, hold.point), axis);
    });
  }
}

void AxisHolds::stop(std::span<Vec3> values) const {
  for (const Hold& hold : holds_)
    for_axes(hold.axes, [&](int axis) { component_of(at(values, hold.point), axis) = 0.0; });
}

void AxisHolds::stop(std::span<const simd::Padded3> base, std::span<simd::Padded3> values) const {
  for (const Hold& hold : holds_) {
    for_axes(hold.axes, [&](int axis) {
      component_of(at(values, hold.point), axis) = -component_of(at(base, hold.point), axis);
    });
  }
}

void AxisHolds::keep(std::span<const Vec3> from, std::span<Vec3> values) const {
  for (const Hold& hold : holds_) {
    for_axes(hold.axes, [&](int axis) {
      component_of(at(values, hold.point), axis) = component_of(at(from, hold.point), axis);
    });
  }
}

void AxisHolds::mark(std::span<std::uint8_t> axes_of_point) const {
  for (const Hold& hold : holds_) at(axes_of_point, hold.point) = hold.axes;
}

}  // namespace palpate::fem

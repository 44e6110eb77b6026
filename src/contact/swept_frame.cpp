#include "contact/swept_frame.hpp"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

/// Three axes of which the first is along `v`, or the axes of space if it is zero.
std::array<Vec3, 3> axes_along(const Vec3& v) {
  const Vec3 first = normalized(v);
  if (first == Vec3{}) return {{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};
  const Vec3 size{std::abs(first.x), std::abs(first.y), std::abs(first.z)};
  Vec3 other{0.0, 0.0, 1.0};
  if (size.x <= size.y && size.x <= size.z) {
    other = {1.0, 0.0, 0.0};
  } else if (size.y <= size.z) {
    other = {0.0, 1.0, 0.0};
  }
  const Vec3 second = normalized(cross(first, other));
  return {first, second, cross(first, second)};
}

}  // namespace

SweptFrame::SweptFrame(const Box& places, const Vec3& first, const Vec3& second, double tolerance)
    : origin_(places.lower), motion_(second), axes_(axes_along(first - second)) {
  // With u = 2^-53 and L the sum of a box's sides and of the motion: differences are off by 2 u L, and
  // products with an axis by 6 u L more.
  constexpr double rounding = 1e-15;
  const Vec3 sides = places.upper - places.lower;
  const double size = sides.x + sides.y + sides.z + length(second);
  const double margin = tolerance + rounding * size;
  margin_ = {margin, margin, margin};
}

}  // namespace palpate

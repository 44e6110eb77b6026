#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"

namespace palpate {

/// |a| without overflow or underflow of its square; unlike std::hypot the same bits with every C library.
inline double scaled_length(const Vec3& a) {
  const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!(largest > 0.0) || !std::isfinite(largest)) return largest;
  return largest * length({a.x / largest, a.y / largest, a.z / largest});
}

}  // namespace palpate

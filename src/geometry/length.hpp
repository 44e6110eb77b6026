#pragma once

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"

namespace palpate {

/// |a|, also where its square overflows or vanishes; the same bits everywhere, unlike std::hypot.
inline double length_of_any(const Vec3& a) {
  const double largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
  if (!(largest > 0.0) || !std::isfinite(largest)) return largest;
  return largest * length({a.x / largest, a.y / largest, a.z / largest});
}

}  // namespace palpate

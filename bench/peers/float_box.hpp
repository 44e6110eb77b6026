#pragma once

#include <cmath>
#include <limits>

namespace palpate::bench {

/// The nearest floats that are not above, and not below, a double: boxes of floats hold those of doubles.
inline float below(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}
inline float above(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace palpate::bench

#pragma once

#include <limits>
#include <string>

#include "scene/units.hpp"

namespace palpate::scene_format {

/// The allowed range of a number in a scene. NaN and infinity are never allowed.
struct Limits {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_open = false;   ///< `low` itself is not allowed
  bool high_open = false;  ///< `high` itself is not allowed
  /// Dimension of the number: defaults are in SI and are converted to the units of the scene.
  Dimension dimension{};

  [[nodiscard]] constexpr bool allow(double x) const {
    return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high);
  }
  [[nodiscard]] constexpr Limits in(const Dimension& unit) const {
    Limits limits = *this;
    limits.dimension = unit;
    return limits;
  }
};

inline constexpr Limits any{};
constexpr Limits above(double low) {
  return {.low = low, .low_open = true};
}
constexpr Limits at_least(double low) {
  return {.low = low};
}
constexpr Limits within(double low, double high) {
  return {.low = low, .high = high};
}
constexpr Limits strictly_within(double low, double high) {
  return {.low = low, .high = high, .low_open = true, .high_open = true};
}

/// The range as text: "a number > 0", "an integer in [1, 16384]"; `noun` is "a number" or similar.
std::string expected_within(const Limits& limits, const std::string& noun);

}  // namespace palpate::scene_format

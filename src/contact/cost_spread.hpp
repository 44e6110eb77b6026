#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace palpate {

/// Median and high value of several times of the same work, as a forecast.
struct CostSpread {
  double high = 0.0;    ///< above all but the two highest (of five and more)
  double middle = 0.0;  ///< the median
};

/// \param costs  at least one; will be sorted
inline CostSpread spread_of(std::span<double> costs) {
  std::ranges::sort(costs);
  const std::size_t disregarded = std::min<std::size_t>(2, (costs.size() - 1) / 2);
  return {costs[costs.size() - 1 - disregarded], costs[costs.size() / 2]};
}

/// Limit of `high` over the median, so that times in which the system suspended the thread do not matter.
inline constexpr double most_of_middle = 1.5;

}  // namespace palpate

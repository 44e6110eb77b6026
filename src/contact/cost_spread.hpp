#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

namespace palpate {

/// What some times of the same work say of the next.
struct CostSpread {
  double high = 0.0;    ///< as all but the two highest were (of five and more)
  double middle = 0.0;  ///< the median
};

/// \param costs  one at least; are sorted
inline CostSpread spread_of(std::span<double> costs) {
  std::ranges::sort(costs);
  const std::size_t disregarded = std::min<std::size_t>(2, (costs.size() - 1) / 2);
  return {costs[costs.size() - 1 - disregarded], costs[costs.size() / 2]};
}

/// How much more than the median `high` may be taken for: those during which the system put the thread aside
/// do not count.
inline constexpr double most_of_middle = 1.5;

}  // namespace palpate

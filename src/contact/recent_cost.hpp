#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "contact/cost_spread.hpp"

namespace palpate {

/// Forecast of the cost of an operation that is seldom too low: the third highest of the last 32 costs, but
/// at most 1.5 times their median.
class RecentCost {
 public:
  void add(double cost) { last_[next_++ % last_.size()] = cost; }
  [[nodiscard]] bool known() const { return next_ > 0; }
  [[nodiscard]] double high() const {
    if (!known()) return 0.0;
    std::array<double, 32> costs = last_;
    const CostSpread spread = spread_of(std::span(costs).first(std::min(next_, costs.size())));
    return std::min(spread.high, most_of_middle * spread.middle);
  }

 private:
  std::array<double, 32> last_{};
  std::size_t next_ = 0;
};

}  // namespace palpate

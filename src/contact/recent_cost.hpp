#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace palpate {

/// What something has cost lately, as a forecast that is seldom too low: the second highest of the last 32.
class RecentCost {
 public:
  void add(double cost) { last_[next_++ % last_.size()] = cost; }
  [[nodiscard]] bool known() const { return next_ > 0; }
  [[nodiscard]] double high() const {
    double highest = 0.0;
    double second = 0.0;
    for (std::size_t i = 0; i < std::min(next_, last_.size()); ++i) {
      second = std::max(second, std::min(highest, last_[i]));
      highest = std::max(highest, last_[i]);
    }
    return next_ > 1 ? second : highest;
  }

 private:
  std::array<double, 32> last_{};
  std::size_t next_ = 0;
};

}  // namespace palpate

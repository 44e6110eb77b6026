#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace palpate {

/// What something has cost lately, as a forecast that is seldom too low: the third highest of the last 32,
/// but at most half more than their median, so that those during which the system put the thread aside do not
/// count.
class RecentCost {
 public:
  void add(double cost) { last_[next_++ % last_.size()] = cost; }
  [[nodiscard]] bool known() const { return next_ > 0; }
  [[nodiscard]] double high() const {
    constexpr std::size_t disregarded = 2;
    constexpr double most_of_median = 1.5;
    std::array<double, 32> sorted = last_;
    const std::size_t count = std::min(next_, sorted.size());
    if (count == 0) return 0.0;
    std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
    return std::min(sorted[count - 1 - std::min(disregarded, (count - 1) / 2)],
                    most_of_median * sorted[count / 2]);
  }

 private:
  std::array<double, 32> last_{};
  std::size_t next_ = 0;
};

}  // namespace palpate

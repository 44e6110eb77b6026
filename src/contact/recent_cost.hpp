#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace palpate {

/// What something has cost lately, as a forecast: the third quartile of the last 32, so that those during
/// which the system put the thread aside do not count.
class RecentCost {
 public:
  void add(double cost) { last_[next_++ % last_.size()] = cost; }
  [[nodiscard]] bool known() const { return next_ > 0; }
  [[nodiscard]] double high() const {
    std::array<double, 32> sorted = last_;
    const std::size_t count = std::min(next_, sorted.size());
    if (count == 0) return 0.0;
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(count);
    const auto place = sorted.begin() + static_cast<std::ptrdiff_t>(3 * (count - 1) / 4);
    std::nth_element(sorted.begin(), place, end);
    return *place;
  }

 private:
  std::array<double, 32> last_{};
  std::size_t next_ = 0;
};

}  // namespace palpate

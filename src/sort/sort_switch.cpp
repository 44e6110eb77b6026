#include "sort/sort_switch.hpp"

#include <algorithm>

namespace palpate {

bool SortSwitch::repairs(std::size_t movers, std::size_t words) {
  const double share = static_cast<double>(movers) / static_cast<double>(std::max<std::size_t>(words, 1));
  if (share > upper_share) {
    repairing_ = false;
  } else if (share < lower_share) {
    repairing_ = true;
  }
  return repairing_;
}

}  // namespace palpate

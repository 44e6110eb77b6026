#include "sort/sort_switch.hpp"

#include <algorithm>

namespace palpate {

bool SortSwitch::repairs(std::size_t movers, std::size_t words) {
  const double fraction = static_cast<double>(movers) / static_cast<double>(std::max<std::size_t>(words, 1));
  if (fraction > upper_fraction) {
    repairing_ = false;
  } else if (fraction < lower_fraction) {
    repairing_ = true;
  }
  return repairing_;
}

}  // namespace palpate

#include "grid/hash.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include <palpate/error.hpp>

namespace palpate {
namespace {

bool is_prime(std::size_t n) {
  for (std::size_t d = 2; d * d <= n; ++d) {
    if (n % d == 0) return false;
  }
  return n > 1;
}

}  // namespace

void HashGrid::clear(std::size_t primitives) {
  constexpr std::size_t fewest = 64;
  const std::size_t n = std::max(primitives, fewest);
  if (head_.size() < 2 * n || head_.size() > 16 * n) {
    // More slots than needed, so that the table keeps its size over many frames.
    std::size_t slots = 4 * n + 1;
    while (!is_prime(slots)) ++slots;
    head_.resize(slots);
    head_.shrink_to_fit();
  }
  std::fill(head_.begin(), head_.end(), -1);
  links_.clear();
}

void HashGrid::insert(std::int32_t i, std::int32_t j, std::int32_t k, Index reference) {
  if (links_.size() >= static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw Error("hash grid", "", "more entries (cells covered by primitives)",
                "at most 2147483647; use a larger cell size");
  }
  Index& head = head_[slot_of(i, j, k)];
  links_.push_back({packed(i, j, k), reference, head});
  head = static_cast<Index>(links_.size() - 1);
}

}  // namespace palpate

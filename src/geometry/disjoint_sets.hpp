#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// Disjoint sets of the numbers 0 to count - 1 (union-find with path halving). The lowest number of a set
/// stands for it, so that results do not depend on the order of joins.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : lower_(count) {
    std::iota(lower_.begin(), lower_.end(), Index{0});
  }
  /// The lowest number of the set of i. O(log count).
  Index find(Index i) {
    while (at(lower_, i) != i) i = at(lower_, i) = at(lower_, at(lower_, i));
    return i;
  }
  void join(Index i, Index j) {
    const Index a = find(i);
    const Index b = find(j);
    at(lower_, std::max(a, b)) = std::min(a, b);
  }

 private:
  std::vector<Index> lower_;  ///< a lower number of the same set, or itself
};

}  // namespace palpate

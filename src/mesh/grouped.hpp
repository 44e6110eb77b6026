#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// The items 0 to n - 1 by their keys: each row has the items with that key, ascending. An item has any
/// number of keys in [0, rows). O(items + keys + rows).
/// \param keys_of  (item) -> range of keys
template <class KeysOf>
Rows grouped(std::size_t items, std::size_t rows, KeysOf&& keys_of) {
  Rows groups;
  groups.begin.assign(rows + 1, 0);
  for (std::size_t i = 0; i < items; ++i)
    for (const Index key : keys_of(i)) ++at(groups.begin, key + 1);
  std::partial_sum(groups.begin.begin(), groups.begin.end(), groups.begin.begin());
  groups.values.resize(static_cast<std::size_t>(groups.begin.back()));
  std::vector<Index> next(groups.begin.begin(), groups.begin.end() - 1);
  for (std::size_t i = 0; i < items; ++i)
    for (const Index key : keys_of(i)) at(groups.values, at(next, key)++) = static_cast<Index>(i);
  return groups;
}

}  // namespace palpate

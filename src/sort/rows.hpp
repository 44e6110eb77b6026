#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "room.hpp"
namespace palpate {

/// Stable counting sort: puts `items` into rows by key(item) in [0, rows). Row r of `sorted` is
/// [begin[r], begin[r + 1]). O(items + rows).
template <class T, class Key>
void sort_into_rows(std::span<const T> items, std::size_t rows, Key&& key, std::vector<Index>& begin,
                    std::vector<T>& sorted) {
  assign_with_room(begin, rows + 1, Index{0});
  for (const T& item : items) ++begin[static_cast<std::size_t>(key(item)) + 1];
  for (std::size_t r = 0; r < rows; ++r) begin[r + 1] += begin[r];
  resize_with_room(sorted, items.size());
  for (const T& item : items)
    sorted[static_cast<std::size_t>(begin[static_cast<std::size_t>(key(item))]++)] = item;
  // The writes have advanced each start to that of the next row: shift them back.
  for (std::size_t r = rows; r > 0; --r) begin[r] = begin[r - 1];
  begin[0] = 0;
}

}  // namespace palpate

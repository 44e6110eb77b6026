#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate {

/// Counts of a query. Each chunk counts separately; then the counts are added up.
struct QueryTally {
  std::size_t candidates = 0;               ///< pairs tested
  std::size_t approximated_primitives = 0;  ///< primitives that cover more cells than they have slots
  std::size_t dropped_cells = 0;
  std::size_t folded_pairs = 0;  ///< points in tets of their own body because of inverted tissue

  /// Counts a primitive of which `left_out` cells got no slot.
  void add_footprint(std::uint64_t left_out) {
    approximated_primitives += left_out > 0 ? 1 : 0;
    dropped_cells += left_out;
  }
  QueryTally& operator+=(const QueryTally& other) {
    candidates += other.candidates;
    approximated_primitives += other.approximated_primitives;
    dropped_cells += other.dropped_cells;
    folded_pairs += other.folded_pairs;
    return *this;
  }
};

inline QueryTally total(std::span<const QueryTally> parts) {
  QueryTally sum;
  for (const QueryTally& part : parts) sum += part;
  return sum;
}

}  // namespace palpate

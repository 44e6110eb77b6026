#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/padded.hpp"

namespace palpate::fem {

/// Sums, at each point, over the corners of its elements. There are two stages, so that the values of corners
/// stay in the first-level cache: each chunk of elements adds up its values for each of its points, then each
/// point adds up the results of the chunks. Both sums have a fixed order, so the bits are the same for every
/// thread count.
class CornerSums {
 public:
  static constexpr std::size_t chunk = 128;  ///< elements
  /// Values at the corners of the elements of a chunk, in element order: x, y, z and 0 for each corner.
  using Values = std::array<double, 16 * chunk>;

  CornerSums() = default;
  /// O(n_elements + n_points).
  CornerSums(std::span<const Tet> corners, std::size_t point_count);

  /// Adds the values of chunk `number`: elements [chunk * number, chunk * (number + 1)), fewer in the last
  /// chunk. Chunks are independent of each other.
  void take(std::size_t number, const Values& values);
  /// Sums at all points (n_points), after the values of every chunk were added; zero at points without
  /// elements.
  void collect(const parallel::Threads& threads, std::span<simd::Padded3> sums) const;

 private:
  std::vector<std::uint16_t> place_of_corner_;  ///< index of each corner's point within its chunk
  std::vector<std::uint32_t> chunk_begin_;      ///< (n_chunks + 1) into part_sums_
  simd::AlignedVector<simd::Padded3> part_sums_;
  // Points are sorted by their number of chunks, so that the length of the inner loop changes rarely and is
  // predicted.
  std::vector<Index> points_;
  std::vector<std::uint32_t> part_begin_;  ///< (n_points + 1), as points_
  std::vector<std::uint32_t> parts_;       ///< into part_sums_, ascending
};

}  // namespace palpate::fem

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "simd/cluster_query.hpp"

namespace palpate {

/// Collects the rows of the clusters of a block. A full block is processed at once, and then refilled with
/// the remaining rows. \tparam Finish  finish() processes a block
template <class Finish>
class BlockRows {
 public:
  BlockRows(simd::ClusterBlock& block, Finish& finish) : block_(block), finish_(finish) {}

  /// Starts the rows of cluster c; clusters ascend.
  void begin(std::size_t c) {
    cluster_ = c;
    block_.first_row[c] = static_cast<std::uint32_t>(rows_);
  }
  /// Adds the items [begin, end); may be empty.
  void add(std::uint32_t begin, std::uint32_t end) {
    if (is_full(end - begin)) begin = add_parts(begin, end);
    // An empty row is overwritten by the next: cheaper than a branch.
    block_.rows[rows_] = {begin, end};
    rows_ += begin < end ? 1 : 0;
    items_ += end - begin;
  }
  void end() {
    block_.first_row[block_.clusters] = static_cast<std::uint32_t>(rows_);
    finish_();
  }

 private:
  /// Whether `more` items do not fit into the block.
  [[nodiscard]] bool is_full(std::uint32_t more) const {
    return items_ + more > simd::ClusterBlock::most_points || rows_ == simd::ClusterBlock::most_rows;
  }
  /// Processes full blocks until [result, end) fits. Rare, so it is not inlined where rows are added.
  [[gnu::noinline]] std::uint32_t add_parts(std::uint32_t begin, std::uint32_t end) {
    while (is_full(end - begin)) {
      const std::size_t room =
          rows_ == simd::ClusterBlock::most_rows ? 0 : simd::ClusterBlock::most_points - items_;
      const auto part = static_cast<std::uint32_t>(std::min<std::size_t>(room, end - begin));
      if (part > 0) block_.rows[rows_++] = {begin, begin + part};
      begin += part;
      finish_early();
    }
    return begin;
  }
  void finish_early() {
    for (std::size_t later = cluster_ + 1; later <= block_.clusters; ++later)
      block_.first_row[later] = static_cast<std::uint32_t>(rows_);
    finish_();
    for (std::size_t done = 0; done <= cluster_; ++done) block_.first_row[done] = 0;
    rows_ = 0;
    items_ = 0;
  }

  simd::ClusterBlock& block_;
  Finish& finish_;
  std::size_t cluster_ = 0;
  std::size_t rows_ = 0;
  std::size_t items_ = 0;
};

}  // namespace palpate

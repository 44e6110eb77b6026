#pragma once

#include <cstddef>
#include <numeric>
#include <optional>
#include <vector>

#include <palpate/settings.hpp>

#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// All pairs: every query visits every primitive, or every point with a cell. The reference for the other
/// structures, with the same interface.
class BruteForce {
 public:
  template <class Footprint>
  void build(const parallel::Threads& /*threads*/, const Lattice& /*lattice*/, std::size_t count,
             Footprint&& /*footprint*/) {
    all_.resize(count);
    std::iota(all_.begin(), all_.end(), Index{0});
  }
  /// \param cell_of  the cell of a point; none: the point is left out
  template <class CellOf>
  std::optional<Sort> build_points(const parallel::Threads& /*threads*/, const Lattice& /*lattice*/,
                                   std::size_t count, CellOf&& cell_of) {
    all_.clear();
    all_.reserve(count);
    for (Index p = 0; p < static_cast<Index>(count); ++p) {
      if (cell_of(p)) all_.push_back(p);
    }
    return {};
  }
  template <class Visit>
  void for_each(const CellRange& /*range*/, Visit&& visit) const {
    for (const Index p : all_) visit(p);
  }
  [[nodiscard]] std::size_t bytes() const { return all_.capacity() * sizeof(Index); }

 private:
  std::vector<Index> all_;  ///< ascending
};

}  // namespace palpate

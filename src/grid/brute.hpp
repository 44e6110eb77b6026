#pragma once

#include <cstddef>

#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// All pairs: every query visits every primitive. The reference for the other structures, with the same
/// interface.
class BruteForce {
 public:
  template <class Footprint>
  void build(const parallel::Threads& /*threads*/, const Lattice& /*lattice*/, std::size_t count,
             Footprint&& /*footprint*/) {
    count_ = static_cast<Index>(count);
  }
  template <class Visit>
  void for_each(const CellRange& /*range*/, Visit&& visit) const {
    for (Index p = 0; p < count_; ++p) visit(p);
  }
  [[nodiscard]] std::size_t bytes() const { return 0; }

 private:
  Index count_ = 0;
};

}  // namespace palpate

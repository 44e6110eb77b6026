#pragma once

#include <string>
#include <vector>

#include "grid/brute.hpp"
#include "grid/compact.hpp"
#include "grid/cuckoo.hpp"
#include "grid/hash.hpp"
#include "grid/lattice.hpp"
#include "grid/uniform.hpp"
#include "support/random.hpp"

namespace palpate::test {

inline Cell random_cell(Random& random, const Cell& size) {
  return {random.integer(0, size[0] - 1), random.integer(0, size[1] - 1), random.integer(0, size[2] - 1)};
}

/// The cells that each primitive covers, and the lattice they are cells of.
struct Covered {
  Lattice lattice;
  std::vector<std::vector<Cell>> cells;  ///< of each primitive, none twice

  [[nodiscard]] auto footprint() const {
    return [this](Index p, auto&& emit) {
      for (const Cell& c : at(cells, p)) emit(c[0], c[1], c[2]);
    };
  }
};

template <class Grid>
void build(Grid& grid, const Covered& covered, int threads = 1) {
  grid.build(parallel::Threads(threads), covered.lattice, covered.cells.size(), covered.footprint());
}

/// What a query visits, in its order.
template <class Grid>
std::vector<Index> visits(const Grid& grid, const CellRange& range) {
  std::vector<Index> visited;
  grid.for_each(range, [&](Index p) { visited.push_back(p); });
  return visited;
}

/// A structure with a fixed order, so that both are one type of a typed suite.
template <class Grid, Order order>
struct In : Grid {
  In() : Grid(order) {}
};

/// Whether queries visit just the primitives of their cells, once for each cell they cover.
template <Order order>
bool exact(const In<UniformGrid, order>& grid) {
  return grid.shift() == 0;
}
template <Order order>
bool exact(const In<CompactGrid, order>& grid) {
  return grid.key_shift() == 0;
}
inline bool exact(const HashGrid& /*grid*/) {
  return true;
}
template <Order order>
bool exact(const In<CuckooGrid, order>& /*grid*/) {
  return true;
}
inline bool exact(const BruteForce& /*grid*/) {
  return false;
}

}  // namespace palpate::test

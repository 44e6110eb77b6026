#pragma once

#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/layers.hpp"
#include "contact/pair_filter.hpp"
#include "contact/point_in_tet.hpp"
#include "contact/query_tally.hpp"
#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "grid/cell_slots.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// Point-in-volume query (paper 4.2, "Parallel query"): loops over the tets in parallel and tests the points
/// that the structure holds in the cells of the tet's box. Deviation: the paper counts in one pass and writes
/// in a second. Here each chunk writes its own list, and the lists are joined in chunk order.
class PointsInTets {
 public:
  template <class Structure>
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const PairFilter& may_touch, const Lattice& lattice, const Structure& points,
            const CellSlots& slots) {
    constexpr std::size_t grain = 256;
    const std::span<const Tet> tets = bodies.tets();
    tallies_.assign(parallel::chunk_count(tets.size(), grain), {});
    lists_.fill(
        threads, tets.size(), grain, [&](std::size_t begin, std::size_t end, std::vector<PointInTet>& found) {
          QueryTally tally;
          for (std::size_t t = begin; t < end; ++t) {
            const Tet& tet = tets[t];
            const Index body = bodies.body_of(tet);
            const Box box = box_of(positions, tet);
            const auto test = [&](Index p) {
              const Index own = at(bodies.body_of_point(), p);
              if (!may_touch(own, body, p, tet)) return;
              ++tally.candidates;
              const Vec3& x = at(positions, p);
              if (box.contains(x) && point_in_tet(x, at(positions, tet[0]), at(positions, tet[1]),
                                                  at(positions, tet[2]), at(positions, tet[3]))) {
                const PointInTet pair{p, static_cast<Index>(t)};
                if (own == body && is_fold(bodies, positions, p, pair.tet)) {
                  ++tally.folded_pairs;
                } else if (own == body || !may_touch.are_tied(own, std::array{p}, body, tet)) {
                  found.push_back(pair);
                }
              }
            };
            const CellRange cells = lattice.cells_of(box);
            if (slots.exact()) {
              points.for_each(cells, test);
            } else {
              tally.add_footprint(slots.left_out(cells.count()));
              slots.for_each_range(t, cells, [&](const CellRange& part) { points.for_each(part, test); });
            }
          }
          tallies_[begin / grain] = tally;
        });
    lists_.join(threads, found_);
  }

  /// The points in tets, sorted by tet.
  [[nodiscard]] std::span<const PointInTet> found() const { return found_; }
  [[nodiscard]] QueryTally tally() const { return total(tallies_); }

 private:
  parallel::ChunkedList<PointInTet> lists_;
  std::vector<PointInTet> found_;
  std::vector<QueryTally> tallies_;
};

}  // namespace palpate

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/clustered_crossings.hpp"
#include "contact/crossing_parameters.hpp"
#include "contact/query_tally.hpp"
#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "grid/cell_slots.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"
#include "sort/rows.hpp"

namespace palpate {

/// Edge-triangle query (paper 3 and 4). The border edges are put into the structure, by the cells they pass.
/// The surface triangles of the penetrated bodies search for them in the cells of their boxes.
///
/// With clusters, ClusteredCrossings does this for all edges but the long ones.
class CrossingQuery {
 public:
  void use_clusters(const Bodies& bodies) { clustered_ = std::make_unique<ClusteredCrossings>(bodies); }

  /// \param fixed  fixed positions, if clusters are used
  template <class Structure>
  void find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
            const Contacts& contacts, std::span<const BorderEdge> border_edges, const Lattice& cells,
            Structure& edges, const CellSlots& slots, const FixedPositions* fixed = nullptr) {
    edges_.clear();
    make_room(edges_, border_edges.size());
    if (fixed != nullptr) {
      clustered_->find(threads, bodies, positions, contacts, border_edges, cells, *fixed, edges_);
    } else {
      for (std::size_t e = 0; e < border_edges.size(); ++e) edges_.push_back(static_cast<Index>(e));
    }
    if (edges_.empty()) {
      clear_search();
    } else {
      search(threads, bodies, positions, contacts, border_edges, cells, edges, slots);
    }
    std::span<const EdgeInTriangle> found = found_;
    if (fixed != nullptr && found_.empty()) {
      found = clustered_->found();
    } else if (fixed != nullptr) {
      make_room(found_, found_.size() + clustered_->found().size());
      found_.insert(found_.end(), clustered_->found().begin(), clustered_->found().end());
      found = found_;
    }
    sort_into_rows<EdgeInTriangle>(
        found, border_edges.size(), [](const EdgeInTriangle& c) { return c.border_edge; }, begin_, sorted_);
    if (fixed != nullptr) sort_rows(threads, border_edges.size());
    resize_with_room(crossings_, sorted_.size());
    find_parameters(threads, bodies, positions, contacts, border_edges, sorted_, crossings_);
    tally_ = total(tallies_);
    tally_ += total(footprint_tallies_);
    if (fixed != nullptr) tally_ += clustered_->tally();
  }

  /// The query of clusters (ClusteredCrossings).
  [[nodiscard]] ClusteredCrossings& clustered() { return *clustered_; }
  [[nodiscard]] const ClusteredCrossings& clustered() const { return *clustered_; }

  /// The crossings, sorted by (border edge, triangle).
  [[nodiscard]] std::span<const Crossing> crossings() const { return crossings_; }
  /// Swaps crossings() and this list.
  void swap_crossings(std::vector<Crossing>& crossings) { crossings_.swap(crossings); }
  /// Crossings of border edge e: [begin()[e], begin()[e + 1]).
  [[nodiscard]] std::span<const Index> begin() const { return begin_; }
  [[nodiscard]] const QueryTally& tally() const { return tally_; }
  /// Memory of the structure of clusters, bytes.
  [[nodiscard]] std::size_t bytes() const { return clustered_ == nullptr ? 0 : clustered_->bytes(); }

 private:
  void clear_search() {
    found_.clear();
    tallies_.clear();
    footprint_tallies_.clear();
  }
  void sort_rows(const parallel::Threads& threads, std::size_t rows) {
    parallel::for_each(threads, rows, 4096, [&](std::size_t e) {
      if (begin_[e + 1] - begin_[e] < 2) return;
      std::sort(sorted_.begin() + begin_[e], sorted_.begin() + begin_[e + 1],
                [](const EdgeInTriangle& a, const EdgeInTriangle& b) { return a.triangle < b.triangle; });
    });
  }

  /// Finds the crossings of edges_, triangle by triangle. The structure holds indices into edges_.
  template <class Structure>
  void search(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              const Contacts& contacts, std::span<const BorderEdge> border_edges, const Lattice& cells,
              Structure& edges, const CellSlots& slots) {
    const auto border_edge = [&](Index e) -> const BorderEdge& { return at(border_edges, at(edges_, e)); };
    const auto ends_of = [&](Index e) {
      const BorderEdge& edge = border_edge(e);
      return std::array{at(contacts.point, edge.contact), edge.free_point};
    };
    const Lattice lattice = bounded(threads, cells, edges_.size(), [&](std::size_t e) {
      const auto [in, out] = ends_of(static_cast<Index>(e));
      const Vec3 d = at(positions, out) - at(positions, in);
      return std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    });
    const auto footprint = [&](Index e, auto&& emit) {
      const auto [in, out] = ends_of(e);
      const Vec3& a = at(positions, in);
      const Vec3& b = at(positions, out);
      if (slots.exact()) return lattice.for_each_cell_of_segment(a, b, emit);
      std::array<std::uint64_t, CellSlots::most> storage{};
      std::span<const std::uint64_t> chosen;
      const std::uint64_t passed = cells_passed(lattice, a, b);
      // The hash uses the ends of the edge, so the choice does not depend on other edges.
      if (slots.overflows(passed)) chosen = slots.choose(edge_name(in, out), passed, storage);
      std::uint64_t number = 0;
      lattice.for_each_cell_of_segment(a, b, [&](std::int32_t i, std::int32_t j, std::int32_t k) {
        if (chosen.empty() || std::binary_search(chosen.begin(), chosen.end(), number)) emit(i, j, k);
        ++number;
      });
    };
    build(threads, lattice, edges_.size(), slots, footprint, edges);
    count_left_out(threads, positions, edges_.size(), lattice, slots, ends_of);
    mark_penetrated(bodies, contacts, border_edges);

    constexpr std::size_t grain = 256;
    const std::span<const Triangle> triangles = bodies.triangles();
    tallies_.assign(parallel::chunk_count(triangles.size(), grain), {});
    near_.resize(std::max(near_.size(), tallies_.size()));
    lists_.fill(
        threads, triangles.size(), grain,
        [&](std::size_t begin, std::size_t end, std::vector<EdgeInTriangle>& found) {
          std::vector<Index>& near = near_[begin / grain];
          const std::size_t capacity = near.capacity();
          for (std::size_t t = begin; t < end; ++t) {
            const Triangle& triangle = triangles[t];
            const Index body = bodies.body_of(triangle);
            if (at(penetrated_, body) == 0) continue;
            const Box box = box_of(positions, triangle);
            near.clear();
            edges.for_each(lattice.cells_of(box), [&](Index e) {
              if (at(contacts.body, border_edge(e).contact) == body) near.push_back(e);
            });
            // An edge may pass several cells of the triangle's box, but is one candidate.
            std::sort(near.begin(), near.end());
            near.erase(std::unique(near.begin(), near.end()), near.end());
            tallies_[begin / grain].candidates += near.size();
            const Vec3& t0 = at(positions, triangle[0]);
            const Vec3& t1 = at(positions, triangle[1]);
            const Vec3& t2 = at(positions, triangle[2]);
            for (const Index e : near) {
              const auto ends = ends_of(e);
              // Triangles of the own body at the ends of the edge meet it only at these ends.
              const auto own = [&](Index corner) { return corner == ends[0] || corner == ends[1]; };
              if (std::any_of(triangle.begin(), triangle.end(), own)) continue;
              const Vec3& in = at(positions, ends[0]);
              const Vec3& out = at(positions, ends[1]);
              if (!box.overlaps(box_of(positions, ends)) || !segment_meets_triangle(in, out, t0, t1, t2))
                continue;
              found.push_back({at(edges_, e), static_cast<Index>(t)});
            }
          }
          keep_room(near, capacity, 2 * near.capacity() + 16);
        });
    lists_.join(found_);
  }

  static std::uint64_t edge_name(Index in, Index out) {
    return (std::uint64_t{1} << 63) | (static_cast<std::uint64_t>(in) << 31) |
           static_cast<std::uint64_t>(out);
  }
  /// In approximate mode, L of the compact grid is an array of fixed size.
  template <class Footprint, class Structure>
  static void build(const parallel::Threads& threads, const Lattice& lattice, std::size_t count,
                    const CellSlots& slots, Footprint&& footprint, Structure& edges) {
    if constexpr (requires { edges.build_slots(threads, lattice, count, std::size_t{1}, footprint); }) {
      if (!slots.exact())
        return edges.build_slots(threads, lattice, count, static_cast<std::size_t>(slots.count()), footprint);
    }
    edges.build(threads, lattice, count, footprint);
  }
  static std::uint64_t cells_passed(const Lattice& lattice, const Vec3& a, const Vec3& b) {
    std::uint64_t cells = 0;
    lattice.for_each_cell_of_segment(a, b, [&](std::int32_t, std::int32_t, std::int32_t) { ++cells; });
    return cells;
  }
  /// In approximate mode: counts the cells of border edges that got no slot.
  template <class EndsOf>
  void count_left_out(const parallel::Threads& threads, std::span<const Vec3> positions, std::size_t edges,
                      const Lattice& lattice, const CellSlots& slots, EndsOf&& ends_of) {
    constexpr std::size_t grain = 1024;
    assign_with_room(footprint_tallies_, slots.exact() ? 0 : parallel::chunk_count(edges, grain),
                     QueryTally{});
    if (slots.exact()) return;
    parallel::for_chunks(threads, edges, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      for (std::size_t e = begin; e < end; ++e) {
        const auto [in, out] = ends_of(static_cast<Index>(e));
        footprint_tallies_[chunk].add_footprint(
            slots.left_out(cells_passed(lattice, at(positions, in), at(positions, out))));
      }
    });
  }
  /// The lattice, with a larger cell size if edges would pass more than 64 cells on average. So memory
  /// depends on the number of edges, not on their length. `extent(e)` is |dx| + |dy| + |dz| of edge e.
  template <class Extent>
  Lattice bounded(const parallel::Threads& threads, const Lattice& cells, std::size_t edges,
                  Extent&& extent) {
    constexpr double most = 64.0;
    const double mean =
        parallel::sum(threads, edges, extent_scratch_, extent) / std::max(1.0, static_cast<double>(edges));
    double cell_size = cells.cell_size();
    while (mean > most * cell_size) cell_size *= 2.0;
    return cell_size == cells.cell_size() ? cells : Lattice(cells.domain(), cell_size);
  }
  void mark_penetrated(const Bodies& bodies, const Contacts& contacts,
                       std::span<const BorderEdge> border_edges) {
    penetrated_.assign(bodies.bodies().size(), 0);
    for (const BorderEdge& edge : border_edges) at(penetrated_, at(contacts.body, edge.contact)) = 1;
  }

  std::unique_ptr<ClusteredCrossings> clustered_;
  std::vector<Index> edges_;  ///< border edges that are searched triangle by triangle
  QueryTally tally_;
  parallel::ChunkedList<EdgeInTriangle> lists_;
  std::vector<EdgeInTriangle> found_;   ///< crossings of all edges, unsorted
  std::vector<EdgeInTriangle> sorted_;  ///< the same, sorted by (border edge, triangle)
  std::vector<Crossing> crossings_;
  std::vector<Index> begin_;
  std::vector<std::uint8_t> penetrated_;
  std::vector<double> extent_scratch_;
  std::vector<std::vector<Index>> near_;  ///< edges near a triangle: scratch of each chunk of triangles
  std::vector<QueryTally> tallies_;
  std::vector<QueryTally> footprint_tallies_;
};

}  // namespace palpate

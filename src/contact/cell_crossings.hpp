#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "contact/crossing_query.hpp"
#include "geometry/box.hpp"
#include "geometry/predicates.hpp"
#include "grid/cell_slots.hpp"
#include "grid/cuckoo.hpp"
#include "grid/lattice.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"
#include "sort/rows.hpp"

namespace palpate {

/// Edge-triangle query by single triangles (paper 3 and 4). The border edges are put into the structure, by
/// the cells they pass. The surface triangles of the penetrated bodies search for them in the cells of their
/// boxes.
template <class Structure>
class CellCrossings final : public CrossingQuery {
 public:
  explicit CellCrossings(Structure edges) : structure_(std::move(edges)) {}

  void find(const Frame& frame, const BorderEdgeView& border,
            const std::optional<WorkLimit>& /*limit*/) override {
    found_.clear();
    tallies_.clear();
    footprint_tallies_.clear();
    if (border.size() > 0) search({frame, border, frame.slots()});
  }

  [[nodiscard]] std::span<const EdgeInTriangle> found() const override { return found_; }
  [[nodiscard]] QueryTally tally() const override {
    QueryTally sum = total(tallies_);
    sum += total(footprint_tallies_);
    return sum;
  }
  [[nodiscard]] std::size_t bytes() const override { return structure_.bytes(); }
  [[nodiscard]] std::optional<CuckooCounts> cuckoo() const override { return cuckoo_counts(structure_); }

 private:
  /// Input of find().
  struct Problem {
    const Frame& frame;
    BorderEdgeView border;
    CellSlots slots;

    [[nodiscard]] std::array<Vec3, 2> segment(Index e) const {
      const auto [in, out] = border.ends(e);
      return {at(frame.positions(), in), at(frame.positions(), out)};
    }
  };

  void search(const Problem& problem) {
    const Lattice lattice = bounded(problem);
    build(problem, lattice);
    count_left_out(problem, lattice);
    problem.border.mark_bodies(penetrated_, problem.frame.bodies().bodies().size());
    constexpr std::size_t grain = 256;
    const std::span<const Triangle> triangles = problem.frame.bodies().triangles();
    tallies_.assign(parallel::chunk_count(triangles.size(), grain), {});
    near_.resize(std::max(near_.size(), tallies_.size()));
    lists_.fill(problem.frame.threads(), triangles.size(), grain,
                [&](std::size_t begin, std::size_t end, std::vector<EdgeInTriangle>& found) {
                  std::vector<Index>& near = near_[begin / grain];
                  const std::size_t capacity = near.capacity();
                  for (std::size_t t = begin; t < end; ++t) {
                    const auto triangle = static_cast<Index>(t);
                    if (at(penetrated_, problem.frame.bodies().body_of(triangles[t])) == 0) continue;
                    list_near(problem, lattice, triangle, near);
                    tallies_[begin / grain].candidates += near.size();
                    test(problem, triangle, near, found);
                  }
                  keep_room(near, capacity, 2 * near.capacity() + 16);
                });
    lists_.join(problem.frame.threads(), by_triangle_);
    sort_into_rows<EdgeInTriangle>(
        by_triangle_, problem.border.size(), [](const EdgeInTriangle& pair) { return pair.border_edge; },
        row_begin_, found_);
  }

  /// Lists the edges in the cells of a triangle's box.
  void list_near(const Problem& problem, const Lattice& lattice, Index t, std::vector<Index>& near) const {
    const Bodies& bodies = problem.frame.bodies();
    const Triangle& triangle = at(bodies.triangles(), t);
    const Index body = bodies.body_of(triangle);
    near.clear();
    structure_.for_each(lattice.cells_of(box_of(problem.frame.positions(), triangle)), [&](Index e) {
      if (problem.border.body(e) == body) near.push_back(e);
    });
    // An edge may pass several cells of the triangle's box, but is one candidate.
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
  }

  static void test(const Problem& problem, Index t, std::span<const Index> near,
                   std::vector<EdgeInTriangle>& found) {
    const std::span<const Vec3> x = problem.frame.positions();
    const Triangle& triangle = at(problem.frame.bodies().triangles(), t);
    const Box box = box_of(x, triangle);
    for (const Index e : near) {
      const auto ends = problem.border.ends(e);
      // Triangles of the own body at the ends of the edge meet it only at these ends.
      const auto own = [&](Index corner) { return corner == ends[0] || corner == ends[1]; };
      if (std::any_of(triangle.begin(), triangle.end(), own)) continue;
      if (!box.overlaps(box_of(x, ends)) ||
          !segment_meets_triangle(at(x, ends[0]), at(x, ends[1]), at(x, triangle[0]), at(x, triangle[1]),
                                  at(x, triangle[2])))
        continue;
      found.push_back({t, e});
    }
  }

  static std::uint64_t edge_name(const std::array<Index, 2>& ends) {
    return (std::uint64_t{1} << 63) | (static_cast<std::uint64_t>(ends[0]) << 31) |
           static_cast<std::uint64_t>(ends[1]);
  }
  static std::uint64_t cells_passed(const Lattice& lattice, const std::array<Vec3, 2>& segment) {
    std::uint64_t cells = 0;
    lattice.for_each_cell_of_segment(segment[0], segment[1],
                                     [&](std::int32_t, std::int32_t, std::int32_t) { ++cells; });
    return cells;
  }
  /// In approximate mode, L of the compact grid is an array of fixed size.
  void build(const Problem& problem, const Lattice& lattice) {
    const CellSlots& slots = problem.slots;
    const auto footprint = [&](Index e, auto&& emit) {
      const std::array<Vec3, 2> segment = problem.segment(e);
      if (slots.exact()) return lattice.for_each_cell_of_segment(segment[0], segment[1], emit);
      std::array<std::uint64_t, CellSlots::most> storage{};
      std::span<const std::uint64_t> chosen;
      const std::uint64_t passed = cells_passed(lattice, segment);
      // The hash uses the ends of the edge, so the choice does not depend on other edges.
      if (slots.overflows(passed)) chosen = slots.choose(edge_name(problem.border.ends(e)), passed, storage);
      std::uint64_t number = 0;
      lattice.for_each_cell_of_segment(
          segment[0], segment[1], [&](std::int32_t i, std::int32_t j, std::int32_t k) {
            if (chosen.empty() || std::binary_search(chosen.begin(), chosen.end(), number)) emit(i, j, k);
            ++number;
          });
    };
    const parallel::Threads& threads = problem.frame.threads();
    const std::size_t count = problem.border.size();
    if constexpr (requires { structure_.build_slots(threads, lattice, count, std::size_t{1}, footprint); }) {
      if (!slots.exact()) {
        return structure_.build_slots(threads, lattice, count, static_cast<std::size_t>(slots.count()),
                                      footprint);
      }
    }
    structure_.build(threads, lattice, count, footprint);
  }
  /// In approximate mode: counts the cells of border edges that got no slot.
  void count_left_out(const Problem& problem, const Lattice& lattice) {
    if (problem.slots.exact()) return;
    constexpr std::size_t grain = 1024;
    const std::size_t edges = problem.border.size();
    assign_with_room(footprint_tallies_, parallel::chunk_count(edges, grain), QueryTally{});
    parallel::for_chunks(
        problem.frame.threads(), edges, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
          for (std::size_t e = begin; e < end; ++e) {
            const std::uint64_t passed = cells_passed(lattice, problem.segment(static_cast<Index>(e)));
            footprint_tallies_[chunk].add_footprint(problem.slots.left_out(passed));
          }
        });
  }
  /// The lattice, with a larger cell size if edges would pass more than 64 cells on average. So memory
  /// depends on the number of edges, not on their length.
  Lattice bounded(const Problem& problem) {
    constexpr double most = 64.0;
    const Lattice& cells = problem.frame.lattice();
    const double sum =
        parallel::sum(problem.frame.threads(), problem.border.size(), extent_scratch_, [&](std::size_t e) {
          const auto [in, out] = problem.segment(static_cast<Index>(e));
          const Vec3 d = out - in;
          return std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
        });
    const double mean = sum / static_cast<double>(problem.border.size());
    double cell_size = cells.cell_size();
    while (mean > most * cell_size) cell_size *= 2.0;
    return cell_size == cells.cell_size() ? cells : Lattice(cells.domain(), cell_size);
  }

  Structure structure_;
  parallel::ChunkedList<EdgeInTriangle> lists_;
  std::vector<EdgeInTriangle> by_triangle_;
  std::vector<EdgeInTriangle> found_;
  std::vector<Index> row_begin_;          ///< scratch
  std::vector<std::uint8_t> penetrated_;  ///< (n_bodies)
  std::vector<double> extent_scratch_;
  std::vector<std::vector<Index>> near_;  ///< edges near a triangle: scratch of each chunk of triangles
  std::vector<QueryTally> tallies_;
  std::vector<QueryTally> footprint_tallies_;
};

}  // namespace palpate

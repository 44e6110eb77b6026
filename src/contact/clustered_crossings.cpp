#include "contact/clustered_crossings.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "contact/block_rows.hpp"
#include "geometry/predicates.hpp"

namespace palpate {

using simd::ClusterBlock;
using simd::FixedPoint;

namespace {

/// Edges longer than this, in cells, are handled separately as long edges, because clusters search around
/// their boxes by half the length of the longest other edge.
constexpr std::int64_t most_cells = 4;
/// The cell index that marks a long edge.
constexpr Cell no_cell{-1, -1, -1};

using Extent = std::array<std::int32_t, 3>;
Extent larger(const Extent& a, const Extent& b) {
  return {std::max(a[0], b[0]), std::max(a[1], b[1]), std::max(a[2], b[2])};
}

}  // namespace

/// Input of find() that all chunks use.
struct ClusteredCrossings::Problem {
  const Frame& frame;
  BorderEdgeView border;
  const FixedPositions& fixed;

  [[nodiscard]] std::int32_t most_length() const {
    // Fixed positions are near or below 2^30, and the box of a cluster must fit 31 bits.
    return static_cast<std::int32_t>(std::min(most_cells << fixed.fraction_bits(), std::int64_t{1} << 29));
  }
};

/// Processes a chunk of clusters, block by block.
class ClusteredCrossings::Work {
 public:
  Work(const ClusteredCrossings& query, const Problem& problem, std::vector<EdgeInTriangle>& found,
       std::span<std::uint8_t> answers = {})
      : query_(query), problem_(problem), rows_(query.rows()), found_(found), answers_(answers) {}

  void run(std::span<const Cluster> clusters) {
    const simd::ClusterKernels kernels = simd::cluster_kernels();
    while (!clusters.empty()) {
      const std::size_t n = std::min(clusters.size(), ClusterBlock::most_clusters);
      block_.clusters = n;
      for (std::size_t c = 0; c < n; ++c) block_.cluster[c] = &clusters[c];
      kernels.load(problem_.fixed.points(), query_.clusters_.points, block_);
      look_up(n);
      clusters = clusters.subspan(n);
      block_begin_ += n;
    }
  }
  [[nodiscard]] const QueryTally& tally() const { return tally_; }

 private:
  void look_up(std::size_t n) {
    const auto do_block = [&] { finish(); };
    BlockRows rows(block_, do_block);
    const auto [x, y, z] = query_.longest_;
    const Extent reach{x / 2 + 1, y / 2 + 1, z / 2 + 1};
    for (std::size_t c = 0; c < n; ++c) {
      rows.begin(c);
      const auto [lower, upper, skips] = block_.box[c];
      const auto down = [](std::int32_t from, std::int32_t by) { return std::max(0, from - by); };
      const CellRange cells{
          problem_.fixed.cell_of(
              {down(lower.x, reach[0]), down(lower.y, reach[1]), down(lower.z, reach[2]), 0}),
          problem_.fixed.cell_of({upper.x + reach[0], upper.y + reach[1], upper.z + reach[2], 0})};
      query_.grid_.for_each_interval(cells,
                                     [&](std::uint32_t begin, std::uint32_t end) { rows.add(begin, end); });
    }
    rows.end();
  }

  void finish() {
    simd::filter_edges(rows_, block_);
    simd::test_edges(rows_, *std::ranges::max_element(query_.longest_), block_);
    tally_.candidates += block_.pairs();
    for (std::size_t h = 0; h < block_.hits; ++h) take(block_.hit[h]);
    if (answers_.empty()) return;
    for (std::size_t c = 0; c < block_.clusters; ++c) {
      const bool near = block_.first_candidate[c + 1] > block_.first_candidate[c];
      answers_[block_begin_ + c] |= ClusterQueue::asked | (near ? ClusterQueue::near : 0);
    }
  }

  void take(const ClusterBlock::Hit& hit) {
    const Cluster& cluster = *block_.cluster[hit.cluster];
    const Index edge = reference_of(at(query_.grid_.entries(), hit.entry));
    const std::span<const Index> triangles = query_.clusters_.primitives_of(cluster);
    for (std::uint32_t left = hit.primitives & 0xFFFFU; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      const bool is_found = add(edge, triangles[lane], (hit.primitives >> 16 >> lane & 1) != 0);
      if (is_found && !answers_.empty()) answers_[block_begin_ + hit.cluster] |= ClusterQueue::found;
    }
  }

  bool add(Index edge, Index t, bool surely) {
    const Triangle& triangle = at(problem_.frame.bodies().triangles(), t);
    const auto ends = problem_.border.ends(edge);
    // Triangles of the own body at the ends of the edge meet it only at these ends.
    const auto own = [&](Index corner) { return corner == ends[0] || corner == ends[1]; };
    if (std::any_of(triangle.begin(), triangle.end(), own)) return false;
    const std::span<const Vec3> x = problem_.frame.positions();
    const Vec3& in = at(x, ends[0]);
    const Vec3& out = at(x, ends[1]);
    const Vec3& t0 = at(x, triangle[0]);
    const Vec3& t1 = at(x, triangle[1]);
    const Vec3& t2 = at(x, triangle[2]);
    if (!surely && !segment_meets_triangle(in, out, t0, t1, t2)) return false;
    found_.push_back({edge, t});
    return true;
  }

  const ClusteredCrossings& query_;
  const Problem& problem_;
  simd::EdgeRows rows_;
  std::vector<EdgeInTriangle>& found_;
  std::span<std::uint8_t> answers_;  ///< flags of the clusters to query (ClusterQueue); or empty
  std::size_t block_begin_ = 0;
  QueryTally tally_;
  ClusterBlock block_;
};

void ClusteredCrossings::place_edges(const Problem& problem) {
  constexpr std::size_t grain = 2048;
  const std::size_t n = problem.border.size();
  const parallel::Threads& threads = problem.frame.threads();
  const std::int32_t most = problem.most_length();
  const std::span<const FixedPoint> points = problem.fixed.points();
  resize_with_room(cells_, n);
  assign_with_room(longest_of_chunk_, parallel::chunk_count(n, grain), Extent{});
  parallel::for_chunks(threads, n, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    const BorderEdgeView border = problem.border;
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::int32_t z = 0;
    for (std::size_t e = begin; e < end; ++e) {
      const auto [in, out] = border.ends(static_cast<Index>(e));
      const FixedPoint& a = at(points, in);
      const FixedPoint& b = at(points, out);
      const std::int32_t along_x = std::abs(a.x - b.x);
      const std::int32_t along_y = std::abs(a.y - b.y);
      const std::int32_t along_z = std::abs(a.z - b.z);
      if (std::max({along_x, along_y, along_z}) > most) {
        cells_[e] = no_cell;
        continue;
      }
      x = std::max(x, along_x);
      y = std::max(y, along_y);
      z = std::max(z, along_z);
      cells_[e] = problem.fixed.cell_of({std::min(a.x, b.x) + along_x / 2, std::min(a.y, b.y) + along_y / 2,
                                         std::min(a.z, b.z) + along_z / 2, 0});
    }
    longest_of_chunk_[chunk] = {x, y, z};
  });
  longest_ = {};
  for (const Extent& extent : longest_of_chunk_) longest_ = larger(longest_, extent);
  long_edges_.clear();
  make_room(long_edges_, n);
  for (std::size_t e = 0; e < n; ++e)
    if (cells_[e][0] < 0) long_edges_.push_back(static_cast<Index>(e));
  grid_.build_points(threads, problem.frame.lattice(), cells_);
}

void ClusteredCrossings::put_in_order(const Problem& problem) {
  const std::span<const Entry> entries = grid_.entries();
  for (auto& numbers : row_) resize_with_room(numbers, entries.size() + simd::row_padding);
  const std::span<const FixedPoint> points = problem.fixed.points();
  parallel::for_each(problem.frame.threads(), entries.size(), 1024,
                     [this, entries, points, border = problem.border](std::size_t i) {
                       const Index edge = reference_of(entries[i]);
                       const auto [in, out] = border.ends(edge);
                       const FixedPoint& a = at(points, in);
                       const FixedPoint& b = at(points, out);
                       const std::array<std::int32_t, 7> numbers{
                           a.x, a.y, a.z, b.x, b.y, b.z, border.body(edge)};
                       for (std::size_t k = 0; k < numbers.size(); ++k) row_[k][i] = numbers[k];
                     });
}

simd::EdgeRows ClusteredCrossings::rows() const {
  return {{row_[0].data(), row_[1].data(), row_[2].data()},
          {row_[3].data(), row_[4].data(), row_[5].data()},
          row_[6].data()};
}

void ClusteredCrossings::find_within(const Problem& problem, const WorkLimit& limit) {
  queue_.arrange(clusters_, problem.frame.positions(), limit.region,
                 [&](const Cluster& cluster) { return at(penetrated_, cluster.body) != 0; });
  run_.run(problem.frame.threads(), queue_, limit.allowance,
           [&](std::span<const Cluster> clusters, std::span<std::uint8_t> answers,
               std::vector<EdgeInTriangle>& found) {
             Work work(*this, problem, found, answers);
             work.run(clusters);
             return work.tally();
           });
  std::swap(found_, run_.found());
  tallies_.assign(1, run_.tally());
}

void ClusteredCrossings::choose_clusters() {
  active_.clear();
  make_room(active_, clusters_.clusters.size());
  for (const Cluster& cluster : clusters_.clusters)
    if (at(penetrated_, cluster.body) != 0) active_.push_back(cluster);
}

void ClusteredCrossings::find_short(const Problem& problem) {
  choose_clusters();
  constexpr std::size_t grain = ClusterBlock::most_clusters;
  const std::span<const Cluster> clusters = active_;
  tallies_.assign(parallel::chunk_count(clusters.size(), grain), {});
  lists_.fill(problem.frame.threads(), clusters.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeInTriangle>& found) {
                Work work(*this, problem, found);
                work.run(clusters.subspan(begin, end - begin));
                tallies_[begin / grain] = work.tally();
              });
  lists_.join(found_);
}

void ClusteredCrossings::find(const Frame& frame, const BorderEdgeView& border,
                              const std::optional<WorkLimit>& limit) {
  queue_.clear();
  found_.clear();
  tallies_.clear();
  if (const FixedPositions* const fixed = frame.fixed()) {
    const Problem problem{frame, border, *fixed};
    place_edges(problem);
    put_in_order(problem);
    border.mark_bodies(penetrated_, frame.bodies().bodies().size());
    if (limit) {
      find_within(problem, *limit);
    } else {
      find_short(problem);
    }
    single_triangles_.find_some(frame, border, long_edges_);
  } else {
    single_triangles_.find(frame, border, limit);
  }
  const std::span<const EdgeInTriangle> more = single_triangles_.found();
  make_room(found_, found_.size() + more.size());
  found_.insert(found_.end(), more.begin(), more.end());
}

}  // namespace palpate

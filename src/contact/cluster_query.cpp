#include "contact/cluster_query.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <memory>

#include "contact/block_rows.hpp"
#include "contact/layers.hpp"
#include "geometry/predicates.hpp"

namespace palpate {

using simd::ClusterBlock;
using simd::ClusterBox;

namespace {

/// Points beyond which memory is asked for ahead of its use: fewer stay in the cache of a core anyway.
constexpr std::size_t most_in_cache = 16384;

/// Asks for a line of memory that the next phase needs; changes nothing else.
void prefetch([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#endif
}

}  // namespace

/// A chunk of clusters, block by block.
class ClusterQuery::Work {
 public:
  Work(const ClusterQuery& query, const Bodies& bodies, std::span<const Vec3> positions,
       const PairFilter& may_touch, const CompactGrid& grid, const FixedPositions& fixed,
       std::vector<PointInTet>& found, std::span<std::uint8_t> answers = {})
      : query_(query),
        bodies_(bodies),
        positions_(positions),
        may_touch_(may_touch),
        grid_(grid),
        fixed_(fixed),
        points_in_order_(fixed.rows()),
        asks_ahead_(positions.size() > most_in_cache),
        found_(found),
        answers_(answers) {}

  void run(std::span<const Cluster> clusters) {
    while (!clusters.empty()) {
      block_begin_ = first_;
      const std::size_t n = std::min(clusters.size(), ClusterBlock::most_clusters);
      block_.clusters = n;
      for (std::size_t c = 0; c < n; ++c) block_.cluster[c] = &clusters[c];
      query_.kernels_.load(fixed_.points(), query_.clusters_.points, block_);
      clusters = clusters.subspan(n);
      prepare(n);
      prefetch_corners(clusters);
      look_up(n);
      first_ += n;
    }
  }
  [[nodiscard]] const QueryTally& tally() const { return tally_; }

 private:
  void prepare(std::size_t n) {
    for (std::size_t c = 0; c < n; ++c) {
      const ClusterBox& box = block_.box[c];
      cells_[c] = {fixed_.cell_of(box.lower), fixed_.cell_of(box.upper)};
      if (asks_ahead_) {
        grid_.prefetch_rows(cells_[c]);
        prefetch(query_.clusters_.primitives.data() + block_.cluster[c]->first);
      }
      set_names(*block_.cluster[c], block_.box[c]);
    }
  }

  /// Of the next block.
  void prefetch_corners(std::span<const Cluster> clusters) const {
    if (!asks_ahead_) return;
    for (const Cluster& cluster : clusters.first(std::min(clusters.size(), ClusterBlock::most_clusters)))
      for (const Index point : query_.clusters_.points_of(cluster)) prefetch(&at(fixed_.points(), point));
  }

  /// Which points in its box a cluster leaves out: those of its own body, and those of immovable bodies.
  void set_names(const Cluster& cluster, ClusterBox& box) const {
    const bool immovable = at(may_touch_.immovable, cluster.body) != 0;
    const bool itself = at(may_touch_.self_collision, cluster.body) != 0;
    const Range own = itself ? Range{0, 0} : at(bodies_.bodies(), cluster.body).points;
    box.lower.name = own.begin;
    box.upper.name = own.end - 1;
    box.skips_marked = immovable ? -1 : 0;
  }

  void look_up(std::size_t n) {
    const auto do_block = [&] { finish(); };
    BlockRows rows(block_, do_block);
    for (std::size_t c = 0; c < n; ++c) {
      rows.begin(c);
      grid_.for_each_interval(cells_[c], [&](std::uint32_t begin, std::uint32_t end) {
        rows.add(begin, end);
        if (asks_ahead_) {
          prefetch(points_in_order_.x + begin);
          prefetch(points_in_order_.y + begin);
          prefetch(points_in_order_.z + begin);
          prefetch(points_in_order_.name + begin);
        }
      });
    }
    rows.end();
  }

  void finish() {
    query_.kernels_.filter(points_in_order_, block_);
    query_.kernels_.test(points_in_order_, block_);
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
    const Index point = simd::index_of_name(points_in_order_.name[hit.entry]);
    const bool own = at(bodies_.bodies(), cluster.body).points.contains(point);
    if (!own && may_touch_.ignores(at(bodies_.body_of_point(), point), cluster.body)) return;
    const std::span<const Index> tets = query_.clusters_.primitives_of(cluster);
    const std::uint32_t corners = own ? query_.clusters_.primitives_at(cluster, point) : 0;
    for (std::uint32_t left = hit.primitives & 0xFFFFU & ~corners; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      const bool surely = (hit.primitives >> 16 >> lane & 1) != 0;
      const bool is_found = add({point, tets[lane]}, own, surely);
      if (is_found && !answers_.empty()) answers_[block_begin_ + hit.cluster] |= ClusterQueue::found;
    }
  }

  /// \param own  whether the point is of the tet's body
  bool add(const PointInTet& pair, bool own, bool surely) {
    const Tet& tet = at(bodies_.tets(), pair.tet);
    if (!surely && !point_in_tet(at(positions_, pair.point), at(positions_, tet[0]), at(positions_, tet[1]),
                                 at(positions_, tet[2]), at(positions_, tet[3])))
      return false;
    if (own && at(query_.upright_, bodies_.body_of(tet)) == 0 &&
        is_fold(bodies_, positions_, pair.point, pair.tet)) {
      ++tally_.folded_pairs;
      return false;
    }
    found_.push_back(pair);
    return true;
  }

  const ClusterQuery& query_;
  const Bodies& bodies_;
  std::span<const Vec3> positions_;
  const PairFilter& may_touch_;
  const CompactGrid& grid_;
  const FixedPositions& fixed_;
  simd::PointRows points_in_order_;
  bool asks_ahead_;
  std::vector<PointInTet>& found_;
  std::span<std::uint8_t> answers_;  ///< of the clusters to run; or none
  std::size_t first_ = 0;            ///< of the next block
  std::size_t block_begin_ = 0;
  QueryTally tally_;
  std::array<CellRange, ClusterBlock::most_clusters> cells_;
  ClusterBlock block_;
};

void ClusterQuery::find_upright_bodies(const parallel::Threads& threads, const PairFilter& may_touch,
                                       const FixedPositions& fixed) {
  upright_.assign(may_touch.self_collision.begin(), may_touch.self_collision.end());
  if (std::find(upright_.begin(), upright_.end(), 1) == upright_.end()) return;
  constexpr std::size_t grain = ClusterBlock::most_clusters;
  const std::span<const Cluster> clusters = clusters_.clusters;
  upright_chunks_.assign(parallel::chunk_count(clusters.size(), grain), 1);
  parallel::for_chunks(threads, clusters.size(), grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         ClusterBlock block;
                         block.clusters = 0;
                         for (std::size_t c = begin; c < end; ++c) {
                           if (at(may_touch.self_collision, clusters[c].body) != 0)
                             block.cluster[block.clusters++] = &clusters[c];
                         }
                         kernels_.load(fixed.points(), clusters_.points, block);
                         upright_chunks_[chunk] = kernels_.upright(block) ? 1 : 0;
                       });
  // A chunk of two bodies tells of both that not all is upright: is_fold() says the rest.
  for (std::size_t c = 0; c < clusters.size(); ++c)
    if (upright_chunks_[c / grain] == 0) at(upright_, clusters[c].body) = 0;
}

void ClusterQuery::find(const parallel::Threads& threads, const Bodies& bodies,
                        std::span<const Vec3> positions, const PairFilter& may_touch, const CompactGrid& grid,
                        const FixedPositions& fixed) {
  constexpr std::size_t grain = ClusterBlock::most_clusters;
  const std::span<const Cluster> clusters = clusters_.clusters;
  tallies_.assign(parallel::chunk_count(clusters.size(), grain), {});
  find_upright_bodies(threads, may_touch, fixed);
  lists_.fill(threads, clusters.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<PointInTet>& found) {
                Work work(*this, bodies, positions, may_touch, grid, fixed, found);
                work.run(clusters.subspan(begin, end - begin));
                tallies_[begin / grain] = work.tally();
              });
  lists_.join(found_);
}

void ClusterQuery::find_within(Allowance& allowance, const std::optional<InterestRegion>& region,
                               const parallel::Threads& threads, const Bodies& bodies,
                               std::span<const Vec3> positions, const PairFilter& may_touch,
                               const CompactGrid& grid, const FixedPositions& fixed) {
  find_upright_bodies(threads, may_touch, fixed);
  queue_.arrange(clusters_, positions, region, [](const Cluster&) { return true; });
  run_.run(threads, queue_, allowance,
           [&](std::span<const Cluster> clusters, std::span<std::uint8_t> answers,
               std::vector<PointInTet>& found) {
             Work work(*this, bodies, positions, may_touch, grid, fixed, found, answers);
             work.run(clusters);
             return work.tally();
           });
  std::swap(found_, run_.found());
  tallies_.assign(1, run_.tally());
}

}  // namespace palpate

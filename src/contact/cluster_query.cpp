#include "contact/cluster_query.hpp"

#include <algorithm>
#include <utility>

#include "contact/cluster_lookup.hpp"
#include "prefetch.hpp"
#include "room.hpp"

namespace palpate {

using simd::ClusterBlock;

namespace {

constexpr std::size_t cluster_grain = ClusterBlock::most_clusters;

/// Queries clusters with the points that they look up in the grid.
/// \param answers  flags of the clusters (ClusterQueue); or empty
QueryTally ask_chunk(const PairContext& pairs, const LookupContext& context,
                     std::span<const Cluster> clusters, std::vector<PointInTet>& found,
                     std::span<std::uint8_t> answers = {}) {
  PairTaker taker(pairs, found);
  const simd::FixedPoint* const points = context.fixed.points().data();
  ClusterLookup lookup(context, 0, [&](ClusterBlock& block, std::size_t first) {
    context.kernels.test(points, block);
    taker.tally().candidates += block.pairs();
    for (std::size_t h = 0; h < block.hits; ++h) {
      const ClusterBlock::Hit& hit = block.hit[h];
      const bool is_found = taker.take(*block.cluster[hit.cluster], hit.entry, hit.primitives);
      if (is_found && !answers.empty()) answers[first + hit.cluster] |= ClusterQueue::found;
    }
    if (answers.empty()) return;
    for (std::size_t c = 0; c < block.clusters; ++c) {
      const bool near = block.first_candidate[c + 1] > block.first_candidate[c];
      answers[first + c] |= ClusterQueue::asked | (near ? ClusterQueue::near : 0);
    }
  });
  lookup.run(clusters);
  return taker.tally();
}

/// Tests clusters with the points on their near lists, block by block.
class ListWork {
 public:
  ListWork(const PairContext& pairs, const simd::ClusterKernels& kernels, const NearLists& lists,
           std::span<const simd::FixedPoint> points, std::vector<PointInTet>& found)
      : pairs_(pairs),
        kernels_(kernels),
        lists_(lists),
        points_(points),
        asks_ahead_(points.size() > most_in_cache),
        taker_(pairs, found) {
    block_.at_point = pairs.clusters.at_point.data();
  }

  void run(std::span<const std::uint32_t> numbers) {
    while (!numbers.empty()) {
      const std::size_t n = clusters_of_block(numbers);
      block_.clusters = n;
      for (std::size_t c = 0; c < n; ++c) {
        block_.cluster[c] = &pairs_.clusters.clusters[numbers[c]];
        block_.box[c] = lists_.box(numbers[c]);
      }
      if (asks_ahead_) prefetch_next(numbers.subspan(n));
      kernels_.gather(points_, pairs_.clusters.points, block_);
      const std::span<const std::uint32_t> begin = lists_.begin();
      const std::uint32_t first = begin[numbers[0]];
      const std::uint32_t end = begin[numbers[n - 1] + 1];
      for (std::uint32_t part = first; part < end; part += ClusterBlock::most_points) {
        for (std::size_t c = 0; c < n; ++c)
          block_.first_candidate[c] = std::max(begin[numbers[c]], part) - part;
        block_.first_candidate[n] = std::min<std::uint32_t>(end - part, ClusterBlock::most_points);
        block_.candidates = lists_.points().data() + part;
        ask();
      }
      numbers = numbers.subspan(n);
    }
  }
  QueryTally& tally() { return taker_.tally(); }

 private:
  void prefetch_next(std::span<const std::uint32_t> numbers) const {
    for (const std::uint32_t c : numbers.first(std::min(numbers.size(), ClusterBlock::most_clusters))) {
      const Cluster& cluster = pairs_.clusters.clusters[c];
      for (const Index point : pairs_.clusters.points_of(cluster)) prefetch(&at(points_, point));
      for (const Index point : lists_.list(c)) prefetch(&at(points_, point));
      prefetch(pairs_.clusters.primitives.data() + cluster.first);
    }
  }

  /// Number of clusters, from the first, that make a block: their lists are consecutive and have few enough
  /// points.
  [[nodiscard]] std::size_t clusters_of_block(std::span<const std::uint32_t> numbers) const {
    const std::span<const std::uint32_t> begin = lists_.begin();
    std::size_t n = 1;
    while (n < std::min(numbers.size(), ClusterBlock::most_clusters) &&
           begin[numbers[n]] == begin[numbers[n - 1] + 1] &&
           begin[numbers[n] + 1] - begin[numbers[0]] <= ClusterBlock::most_points)
      ++n;
    return n;
  }

  void ask() {
    kernels_.test(points_.data(), block_);
    taker_.tally().candidates += block_.pairs();
    for (std::size_t h = 0; h < block_.hits; ++h) {
      const ClusterBlock::Hit& hit = block_.hit[h];
      taker_.take(*block_.cluster[hit.cluster], hit.entry, hit.primitives);
    }
  }

  const PairContext& pairs_;
  const simd::ClusterKernels& kernels_;
  const NearLists& lists_;
  std::span<const simd::FixedPoint> points_;
  bool asks_ahead_;
  PairTaker taker_;
  ClusterBlock block_;
};

}  // namespace

void ClusterQuery::find_upright_bodies(const parallel::Threads& threads, const PairFilter& may_touch,
                                       const FixedPositions& fixed) {
  upright_.assign(may_touch.self_collision.begin(), may_touch.self_collision.end());
  if (std::find(upright_.begin(), upright_.end(), 1) == upright_.end()) return;
  const std::span<const Cluster> clusters = clusters_.clusters;
  upright_chunks_.assign(parallel::chunk_count(clusters.size(), cluster_grain), 1);
  parallel::for_chunks(threads, clusters.size(), cluster_grain,
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
  // If a chunk has clusters of two bodies, both are marked as possibly inverted; is_fold() decides.
  for (std::size_t c = 0; c < clusters.size(); ++c)
    if (upright_chunks_[c / cluster_grain] == 0) at(upright_, clusters[c].body) = 0;
}

bool ClusterQuery::begin_frame(const parallel::Threads& threads, const Bodies& bodies,
                               const FixedPositions& fixed, bool new_lattice) {
  if (new_lattice) plan_.drop_lists(clusters_.clusters.size());
  if (plan_.has_lists()) lists_.update(threads, bodies, clusters_, fixed);
  mode_ = plan_.choose(clusters_.clusters.size(), lists_.stale().size());
  return mode_ != FrameMode::listed;
}

void ClusterQuery::recall(const ListPlan::Numbers& plan, const parallel::Threads& threads,
                          const Bodies& bodies, const PairFilter& may_touch, const PointGrid& grid,
                          const FixedPositions& fixed) {
  plan_.set_numbers(plan);
  if (plan_.has_lists()) lists_.make(threads, {clusters_, kernels_, bodies, may_touch, grid, fixed});
}

void ClusterQuery::ask_clusters(const parallel::Threads& threads, const PairContext& pairs,
                                const LookupContext& context, std::span<const Cluster> clusters) {
  const std::size_t before = tallies_.size();
  tallies_.resize(before + parallel::chunk_count(clusters.size(), cluster_grain));
  found_in_chunks_.fill(threads, clusters.size(), cluster_grain,
                        [&](std::size_t begin, std::size_t end, std::vector<PointInTet>& found) {
                          tallies_[before + begin / cluster_grain] =
                              ask_chunk(pairs, context, clusters.subspan(begin, end - begin), found);
                        });
  found_in_chunks_.append(threads, found_, parallel::chunk_count(clusters.size(), cluster_grain));
}

void ClusterQuery::ask_lists(const parallel::Threads& threads, const PairContext& pairs,
                             const FixedPositions& fixed) {
  const std::span<const std::uint32_t> numbers = lists_.asked();
  const std::size_t before = tallies_.size();
  tallies_.resize(before + parallel::chunk_count(numbers.size(), cluster_grain));
  found_in_chunks_.fill(threads, numbers.size(), cluster_grain,
                        [&](std::size_t begin, std::size_t end, std::vector<PointInTet>& found) {
                          ListWork work(pairs, kernels_, lists_, fixed.points(), found);
                          work.run(numbers.subspan(begin, end - begin));
                          tallies_[before + begin / cluster_grain] = work.tally();
                        });
  found_in_chunks_.append(threads, found_, parallel::chunk_count(numbers.size(), cluster_grain));
}

void ClusterQuery::find(const parallel::Threads& threads, const Bodies& bodies,
                        std::span<const Vec3> positions, const PairFilter& may_touch, const PointGrid& grid,
                        const FixedPositions& fixed) {
  find_upright_bodies(threads, may_touch, fixed);
  const PairContext pairs{clusters_, bodies, positions, may_touch, upright_};
  const LookupContext context{clusters_, kernels_, bodies, may_touch, grid, fixed};
  found_.clear();
  tallies_.clear();
  make_room(tallies_, parallel::chunk_count(clusters_.clusters.size(), cluster_grain) + 2);
  last_mode_ = std::exchange(mode_, FrameMode::all);
  if (last_mode_ == FrameMode::list) lists_.make(threads, context);
  if (last_mode_ == FrameMode::all) {
    ask_clusters(threads, pairs, context, clusters_.clusters);
  } else {
    ask_clusters(threads, pairs, context, lists_.stale());
    ask_lists(threads, pairs, fixed);
  }
}

void ClusterQuery::find_within(const WorkLimit& limit, const parallel::Threads& threads, const Bodies& bodies,
                               std::span<const Vec3> positions, const PairFilter& may_touch,
                               const PointGrid& grid, const FixedPositions& fixed) {
  find_upright_bodies(threads, may_touch, fixed);
  const PairContext pairs{clusters_, bodies, positions, may_touch, upright_};
  const LookupContext context{clusters_, kernels_, bodies, may_touch, grid, fixed};
  queue_.arrange(clusters_, positions, limit.region, [](const Cluster&) { return true; });
  run_.run(
      threads, queue_, limit.allowance,
      [&](std::span<const Cluster> clusters, std::span<std::uint8_t> answers,
          std::vector<PointInTet>& found) { return ask_chunk(pairs, context, clusters, found, answers); });
  std::swap(found_, run_.found());
  tallies_.assign(1, run_.tally());
}

}  // namespace palpate

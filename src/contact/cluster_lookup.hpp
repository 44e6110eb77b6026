#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/mesh.hpp>

#include "contact/block_rows.hpp"
#include "contact/pair_filter.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/point_grid.hpp"
#include "mesh/clusters.hpp"
#include "prefetch.hpp"
#include "simd/cluster_query.hpp"

namespace palpate {

/// Input of the look-up of clusters.
struct LookupContext {
  const Clusters& clusters;
  const simd::ClusterKernels& kernels;
  const Bodies& bodies;
  const PairFilter& may_touch;
  const PointGrid& grid;
  const FixedPositions& fixed;
};

/// Lists the candidates of clusters, block by block: the points in their boxes.
/// \tparam Finish  finish(block, first) processes a block; `first` is the index of its first cluster.
///                 Clusters with many candidates come in several blocks.
template <class Finish>
class ClusterLookup {
 public:
  /// \param margin  by how much boxes grow on all sides, in fractions of a cell
  ClusterLookup(const LookupContext& context, std::int32_t margin, Finish finish)
      : context_(context),
        margin_(margin),
        finish_(finish),
        points_(context.grid.rows(context.fixed)),
        asks_ahead_(context.fixed.points().size() > most_in_cache) {
    block_.at_point = context.clusters.at_point.data();
  }

  void run(std::span<const Cluster> clusters) {
    std::size_t first = 0;
    while (!clusters.empty()) {
      const std::size_t n = std::min(clusters.size(), simd::ClusterBlock::most_clusters);
      block_.clusters = n;
      for (std::size_t c = 0; c < n; ++c) block_.cluster[c] = &clusters[c];
      context_.kernels.load(context_.fixed.points(), context_.clusters.points, block_);
      clusters = clusters.subspan(n);
      prepare(n);
      prefetch_corners(clusters);
      search(n, first);
      first += n;
    }
  }

 private:
  void prepare(std::size_t n) {
    for (std::size_t c = 0; c < n; ++c) {
      simd::ClusterBox& box = block_.box[c];
      if (margin_ != 0) widen(box, margin_);
      simd::round_out(box, points_.coarse_shift);
      cells_[c] = {context_.fixed.cell_of(box.lower), context_.fixed.cell_of(box.upper)};
      if (asks_ahead_) {
        context_.grid.cells().prefetch_rows(cells_[c]);
        prefetch(context_.clusters.primitives.data() + block_.cluster[c]->first);
      }
      set_names(*block_.cluster[c], box);
    }
  }

  void prefetch_candidates() const {
    for (std::uint32_t i = 0; i < block_.first_candidate[block_.clusters]; ++i)
      prefetch(points_.points + block_.candidates[i]);
  }

  /// Prefetches the corners of the next block.
  void prefetch_corners(std::span<const Cluster> clusters) const {
    if (!asks_ahead_) return;
    for (const Cluster& cluster :
         clusters.first(std::min(clusters.size(), simd::ClusterBlock::most_clusters))) {
      for (const Index point : context_.clusters.points_of(cluster))
        prefetch(&at(context_.fixed.points(), point));
    }
  }

  /// Sets which points a cluster leaves out: points of its own body; for immovable bodies, points of all
  /// immovable bodies.
  void set_names(const Cluster& cluster, simd::ClusterBox& box) const {
    const bool immovable = at(context_.may_touch.immovable, cluster.body) != 0;
    const bool itself = at(context_.may_touch.self_collision, cluster.body) != 0;
    const Range own = itself ? Range{0, 0} : at(context_.bodies.bodies(), cluster.body).points;
    box.lower.name = own.begin;
    box.upper.name = own.end - 1;
    box.skips_marked = immovable ? -1 : 0;
  }

  void search(std::size_t n, std::size_t first) {
    const auto do_block = [&] {
      context_.kernels.filter(points_, block_);
      if (asks_ahead_) prefetch_candidates();
      finish_(block_, first);
    };
    BlockRows rows(block_, do_block);
    block_.strays = 0;
    for (std::size_t c = 0; c < n; ++c) {
      rows.begin(c);
      block_.strays |= context_.grid.cells().finds_only(cells_[c]) ? 0U : 1U << c;
      context_.grid.cells().for_each_interval(cells_[c], [&](std::uint32_t begin, std::uint32_t end) {
        rows.add(begin, end);
        if (asks_ahead_) {
          prefetch(points_.words + begin);
          prefetch(points_.names + begin);
        }
      });
    }
    rows.end();
  }

  const LookupContext& context_;
  std::int32_t margin_;
  Finish finish_;
  simd::PointRows points_;
  bool asks_ahead_;
  std::array<CellRange, simd::ClusterBlock::most_clusters> cells_;
  simd::ClusterBlock block_;
};

}  // namespace palpate

#include "contact/near_lists.hpp"

#include <algorithm>
#include <limits>

#include "room.hpp"

namespace palpate {

using simd::ClusterBlock;
using simd::ClusterBox;

namespace {

constexpr std::size_t points_in_a_piece = 2048;
/// If there are more boxes of fast bodies than this, one box is used for all.
constexpr std::size_t most_fast_boxes = 16;

/// Allowed motion of points, as a fraction of a cell: 1 / 32. A larger one makes longer lists, a smaller one
/// more of them.
std::int32_t max_motion_in(const FixedPositions& fixed) {
  return std::int32_t{1} << std::max(fixed.fraction_bits() - 5, 0);
}

bool meet(const ClusterBox& a, const ClusterBox& b) {
  return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
         b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}

void extend(ClusterBox& box, const ClusterBox& by) {
  box.lower = {std::min(box.lower.x, by.lower.x), std::min(box.lower.y, by.lower.y),
               std::min(box.lower.z, by.lower.z), 0};
  box.upper = {std::max(box.upper.x, by.upper.x), std::max(box.upper.y, by.upper.y),
               std::max(box.upper.z, by.upper.z), 0};
}

ClusterBox box_of(std::span<const simd::FixedPoint> points) {
  ClusterBox box{points[0], points[0], 0};
  for (const simd::FixedPoint& p : points) extend(box, {p, p, 0});
  return box;
}

}  // namespace

NearLists::NearLists(const Bodies& bodies, std::size_t clusters)
    : clusters_(clusters), is_fast_(bodies.bodies().size()) {
  constexpr auto size = static_cast<Index>(points_in_a_piece);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const Range all = at(bodies.bodies(), b).points;
    for (Index begin = all.begin; begin < all.end; begin += size)
      pieces_.push_back({{begin, std::min(begin + size, all.end)}, b});
  }
  motion_of_piece_.resize(pieces_.size());
}

void NearLists::make(const parallel::Threads& threads, const LookupContext& context) {
  max_motion_ = max_motion_in(context.fixed);
  const std::span<const simd::FixedPoint> points = context.fixed.points();
  resize_with_room(reference_, points.size());
  parallel::for_each(threads, points.size(), points_in_a_piece,
                     [&](std::size_t p) { reference_[p] = points[p]; });
  const std::size_t n = clusters_;
  boxes_.resize(n);
  begin_.assign(n + 1, 0);
  lists_of_chunks_.fill(threads, n, ClusterBlock::most_clusters,
                        [&](std::size_t begin, std::size_t end, std::vector<Index>& list) {
                          list_chunk(context, begin, end, list);
                        });
  lists_of_chunks_.join(threads, points_);
  for (std::size_t c = 0; c < n; ++c) begin_[c + 1] += begin_[c];
  is_stale_.assign(n, 0);
  stale_.clear();
  listed_.clear();
  make_room(listed_, n);
  for (std::size_t c = 0; c < n; ++c)
    if (begin_[c + 1] > begin_[c]) listed_.push_back(static_cast<std::uint32_t>(c));
  list_asked();
}

void NearLists::list_chunk(const LookupContext& context, std::size_t begin, std::size_t end,
                           std::vector<Index>& list) {
  const simd::FixedPoint* const points = context.fixed.points().data();
  const auto finish = [&](ClusterBlock& block, std::size_t first) {
    context.kernels.near(points, max_motion_, block);
    for (std::size_t c = 0; c < block.clusters; ++c) {
      ClusterBox& box = boxes_[begin + first + c] = block.box[c];
      widen(box, max_motion_);
    }
    for (std::size_t h = 0; h < block.hits; ++h) {
      const ClusterBlock::Hit& hit = block.hit[h];
      list.push_back(hit.entry);
      ++begin_[begin + first + hit.cluster + 1];
    }
  };
  // A point that enters the cluster's box later is now no further from it than both can move.
  ClusterLookup lookup(context, 2 * max_motion_, finish);
  lookup.run(std::span(context.clusters.clusters).subspan(begin, end - begin));
}

void NearLists::list_asked() {
  asked_.clear();
  make_room(asked_, listed_.size());
  for (const std::uint32_t c : listed_)
    if (is_stale_[c] == 0) asked_.push_back(c);
}

void NearLists::find_fast_bodies(const parallel::Threads& threads, const Bodies& bodies,
                                 const FixedPositions& fixed) {
  const std::span<const simd::FixedPoint> points = fixed.points();
  const std::span<const simd::FixedPoint> reference = reference_;
  parallel::for_each(threads, pieces_.size(), 1, [&](std::size_t i) {
    const Range& range = pieces_[i].points;
    const auto first = static_cast<std::size_t>(range.begin);
    const auto size = static_cast<std::size_t>(range.size());
    motion_of_piece_[i] = simd::largest_motion(points.subspan(first, size), reference.subspan(first, size));
  });
  std::fill(is_fast_.begin(), is_fast_.end(), std::uint8_t{0});
  for (std::size_t i = 0; i < pieces_.size(); ++i)
    if (motion_of_piece_[i] > max_motion_) at(is_fast_, pieces_[i].body) = 1;
  fast_.clear();
  make_room(fast_, most_fast_boxes);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    if (at(is_fast_, b) == 0) continue;
    const Range& range = at(bodies.bodies(), b).points;
    const ClusterBox box =
        box_of(points.subspan(static_cast<std::size_t>(range.begin), static_cast<std::size_t>(range.size())));
    if (fast_.size() < most_fast_boxes) {
      fast_.push_back(box);
    } else {
      extend(fast_.back(), box);
    }
  }
}

void NearLists::mark_stale(std::span<const Cluster> clusters) {
  stale_.clear();
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    // The box contains all positions that the cluster can have now.
    const bool is_stale =
        at(is_fast_, clusters[c].body) != 0 ||
        std::any_of(fast_.begin(), fast_.end(), [&](const ClusterBox& f) { return meet(f, boxes_[c]); });
    is_stale_[c] = is_stale ? 1 : 0;
    if (!is_stale) continue;
    make_room(stale_, stale_.size() + 1);
    stale_.push_back(clusters[c]);
  }
}

void NearLists::update(const parallel::Threads& threads, const Bodies& bodies, const Clusters& clusters,
                       const FixedPositions& fixed) {
  const bool had_stale = !stale_.empty();
  find_fast_bodies(threads, bodies, fixed);
  if (fast_.empty()) {
    if (!had_stale) return;
    stale_.clear();
    std::fill(is_stale_.begin(), is_stale_.end(), std::uint8_t{0});
  } else {
    mark_stale(clusters.clusters);
  }
  list_asked();
}

std::size_t NearLists::bytes() const {
  return reference_.capacity() * sizeof(simd::FixedPoint) + boxes_.capacity() * sizeof(ClusterBox) +
         (begin_.capacity() + listed_.capacity() + asked_.capacity()) * sizeof(std::uint32_t) +
         points_.capacity() * sizeof(Index);
}

}  // namespace palpate

#include "contact/cluster_pairs.hpp"

#include <algorithm>
#include <array>

#include "geometry/axis.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t facing_grain = 64;

}  // namespace

/// Appends the clusters of both bodies near the other one.
void ClusterPairs::choose_clusters(std::span<const Box> boxes, const FacingBodies& pair, Index number) {
  std::array ranges{at(surface_.of_body, pair.bodies.first), at(surface_.of_body, pair.bodies.second)};
  if (pair.bodies.first == pair.bodies.second) ranges[1] = {};
  const std::size_t axis = longest_axis(pair.common.upper - pair.common.lower);
  const auto first = std::ssize(active_);
  make_room(active_, active_.size() + static_cast<std::size_t>(ranges[0].size() + ranges[1].size()));
  for (const Range& range : ranges) {
    for (Index c = range.begin; c < range.end; ++c) {
      const Box& box = at(boxes, c);
      if (box.overlaps(pair.common))
        active_.push_back({along(axis, box.lower), along(axis, grown(box, pair.margin).upper), c, number});
    }
  }
  std::sort(active_.begin() + first, active_.end(), [](const Active& a, const Active& b) {
    return std::pair(a.lower, a.cluster) < std::pair(b.lower, b.cluster);
  });
}

void ClusterPairs::sweep(std::size_t begin, std::size_t end, std::span<const Box> boxes,
                         std::span<const FacingBodies> pairs, std::vector<Found>& found) const {
  for (std::size_t i = begin; i < end; ++i) {
    const Active& a = active_[i];
    const Box box = grown(at(boxes, a.cluster), at(pairs, a.pair).margin);
    const IndexPair& bodies = at(pairs, a.pair).bodies;
    const Index body = at(surface_.clusters.clusters, a.cluster).body;
    const bool own = bodies.first == bodies.second;
    for (std::size_t j = own ? i : i + 1; j < active_.size(); ++j) {
      const Active& b = active_[j];
      if (b.pair != a.pair || b.lower > a.upper) break;
      if (box.overlaps(at(boxes, b.cluster)) &&
          (own || at(surface_.clusters.clusters, b.cluster).body != body))
        found.push_back({{a.cluster, b.cluster}, at(pairs, a.pair).number});
    }
  }
}

std::span<ClusterPairs::Found> ClusterPairs::find(const parallel::Threads& threads,
                                                  std::span<const Box> boxes,
                                                  std::span<const FacingBodies> pairs) {
  active_.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i) choose_clusters(boxes, pairs[i], static_cast<Index>(i));
  lists_.fill(threads, active_.size(), facing_grain,
              [&](std::size_t begin, std::size_t end, std::vector<Found>& found) {
                sweep(begin, end, boxes, pairs, found);
              });
  lists_.make_even_room();
  lists_.join(threads, found_);
  return found_;
}

}  // namespace palpate

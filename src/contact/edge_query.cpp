#include "contact/edge_query.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/edge_query_frame.hpp"
#include "contact/rim_falloff.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t clusters_of_chunk = 64;

/// The largest power of two that is not above a length; 1 for no length.
double power_of_two(double size) {
  return size > 0.0 ? std::ldexp(1.0, std::ilogb(size)) : 1.0;
}

}  // namespace

EdgeQuery::EdgeQuery(const Bodies& bodies)
    : surface_(bodies),
      blocks_(surface_, bodies),
      clusters_(surface_),
      boxes_(surface_.clusters.clusters.size()),
      motions_(boxes_.size()),
      bodies_(bodies.bodies().size()) {
  for (Index b = 0; b < bodies.body_count(); ++b) reach_.push_back(rim_reach(bodies, b));
}

/// Updates boxes and motions of clusters and bodies. Returns the size of the largest box.
double EdgeQuery::follow(const parallel::Threads& threads, std::span<const Vec3> positions) {
  if (last_.empty()) last_.assign(positions.begin(), positions.end());
  const Clusters& clusters = surface_.clusters;
  parallel::for_each(threads, boxes_.size(), clusters_of_chunk, [&](std::size_t c) {
    Box box;
    Box motion;
    for (const Index p : clusters.points_of(clusters.clusters[c])) {
      const Vec3& x = at(positions, p);
      box.extend(x);
      motion.extend(x - at(last_, p));
    }
    boxes_[c] = box;
    motions_[c] = motion;
  });
  std::ranges::copy(positions, last_.begin());
  std::ranges::fill(bodies_, Motion{});
  double size = 0.0;
  for (std::size_t c = 0; c < boxes_.size(); ++c) {
    Motion& body = at(bodies_, clusters.clusters[c].body);
    body.box.extend(boxes_[c]);
    body.motion.extend(motions_[c]);
    size = std::max(size, largest({{}, boxes_[c].upper - boxes_[c].lower}));
  }
  return size;
}

/// Finds pairs of bodies whose boxes meet and that may touch, and bodies that may touch themselves; existing
/// pairs keep their lists.
void EdgeQuery::pair_bodies(const Frame& frame) {
  body_order_.clear();
  make_room(body_order_, bodies_.size());
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    body_order_.emplace_back(bodies_[b].box.lower.x, static_cast<Index>(b));
  std::ranges::sort(body_order_);
  body_pairs_.clear();
  for (std::size_t i = 0; i < body_order_.size(); ++i) {
    const Index a = body_order_[i].second;
    const Box& box = at(bodies_, a).box;
    if (frame.may_touch.itself(a)) {
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.emplace_back(a, a);
    }
    for (std::size_t j = i + 1; j < body_order_.size() && body_order_[j].first <= box.upper.x; ++j) {
      const Index b = body_order_[j].second;
      if (!box.overlaps(at(bodies_, b).box) || !frame.may_touch.bodies(a, b)) continue;
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.emplace_back(std::min(a, b), std::max(a, b));
    }
  }
  std::ranges::sort(body_pairs_);
  next_.clear();
  make_room(next_, body_pairs_.size());
  for (const IndexPair& pair : body_pairs_) {
    const auto known = std::ranges::lower_bound(pairs_, pair, {}, &NearPair::bodies);
    if (known != pairs_.end() && known->bodies == pair) {
      next_.push_back(std::move(*known));
    } else {
      next_.emplace_back().bodies = pair;
    }
    NearPair& now = next_.back();
    const double last = furthest(at(bodies_, pair.first).motion, at(bodies_, pair.second).motion);
    now.validity.move(last);
  }
  for (const NearPair& gone : pairs_)
    for (const Group& group : gone.groups) unused_ += group.size;
  pairs_.swap(next_);
}

/// Finds the near clusters of pairs that have no valid list of them.
void EdgeQuery::pair_clusters(const Frame& frame) {
  unlisted_.clear();
  make_room(unlisted_, pairs_.size());
  for (const std::size_t i : order_) {
    NearPair& pair = pairs_[i];
    if (pair.validity.is_valid()) continue;
    const double room = pair.validity.renew(most_room(pair));
    const Box common = common_part(grown(at(bodies_, pair.bodies.first).box, room),
                                   grown(at(bodies_, pair.bodies.second).box, room));
    unlisted_.push_back({pair.bodies, common, room, static_cast<Index>(i)});
  }
  const std::span<ClusterPairs::Found> facing = clusters_.find(frame.threads, boxes_, unlisted_);
  std::size_t begin = 0;
  for (const FacingBodies& bodies : unlisted_) {
    std::size_t end = begin;
    for (; end < facing.size() && facing[end].number == bodies.number; ++end) {
      auto& [a, b] = facing[end].clusters;
      if (b < a) std::swap(a, b);
    }
    const auto own = facing.subspan(begin, end - begin);
    std::ranges::sort(own, {}, &ClusterPairs::Found::clusters);
    take_clusters(at(pairs_, bodies.number), own);
    begin = end;
  }
}

/// Replaces the groups of a pair; those that remain keep their lists.
/// \param facing  sorted by clusters
void EdgeQuery::take_clusters(NearPair& pair, std::span<const ClusterPairs::Found> facing) {
  groups_.clear();
  make_room(groups_, facing.size());
  auto old = pair.groups.begin();
  for (const ClusterPairs::Found& found : facing) {
    for (; old != pair.groups.end() && old->clusters < found.clusters; ++old) unused_ += old->size;
    if (old != pair.groups.end() && old->clusters == found.clusters) {
      groups_.push_back(*old++);
    } else {
      groups_.emplace_back().clusters = found.clusters;
    }
  }
  for (; old != pair.groups.end(); ++old) unused_ += old->size;
  make_room(pair.groups, groups_.size());
  pair.groups.assign(groups_.begin(), groups_.end());
  if (pair.first >= groups_.size()) pair.first = 0;
}

void EdgeQuery::find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const PairFilter& may_touch, const ContactTable& contacts, const Deadline& deadline) {
  is_timed_ = deadline.exists();
  work_.all = work_.late = 0;
  work_.late_pairs.clear();
  const double unit = power_of_two(follow(threads, positions));
  const Frame frame{threads,
                    bodies,
                    positions,
                    may_touch,
                    contacts,
                    deadline,
                    {surface_, blocks_, positions, boxes_, unit}};
  pair_bodies(frame);
  order_pairs();
  pair_clusters(frame);
  choose_tasks(frame);
  list_groups(frame);
  test_groups(frame);
  std::ranges::sort(found_, {}, [](const EdgeTriangle& hit) { return std::pair(hit.edge, hit.triangle); });
  leave_out_tasks();
  end_pairs(bodies);
}

}  // namespace palpate

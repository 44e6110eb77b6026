#include "contact/edge_query.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "contact/edge_query_frame.hpp"
#include "contact/rim_falloff.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// The largest power of two that is not above a length; 1 for no length.
double power_of_two(double size) {
  return size > 0.0 ? std::ldexp(1.0, std::ilogb(size)) : 1.0;
}

}  // namespace

EdgeQuery::EdgeQuery(const Bodies& bodies, bool keeps_lists)
    : keeps_lists_(keeps_lists),
      surface_(bodies),
      blocks_(surface_, bodies),
      clusters_(surface_),
      motions_(surface_, bodies),
      lost_(surface_, bodies) {
  for (Index b = 0; b < bodies.body_count(); ++b) reach_.push_back(rim_reach(bodies, b));
}

/// Finds pairs of bodies whose boxes meet and that may touch, and bodies that may touch themselves; existing
/// pairs keep their lists.
void EdgeQuery::pair_bodies(const Frame& frame) {
  body_order_.clear();
  make_room(body_order_, reach_.size());
  for (Index b = 0; b < std::ssize(reach_); ++b) body_order_.emplace_back(motions_.box_of_body(b).lower.x, b);
  std::ranges::sort(body_order_);
  body_pairs_.clear();
  for (std::size_t i = 0; i < body_order_.size(); ++i) {
    const Index a = body_order_[i].second;
    const Box& box = motions_.box_of_body(a);
    if (frame.may_touch.itself(a)) {
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.emplace_back(a, a);
    }
    for (std::size_t j = i + 1; j < body_order_.size() && body_order_[j].first <= box.upper.x; ++j) {
      const Index b = body_order_[j].second;
      if (!box.overlaps(motions_.box_of_body(b)) || !frame.may_touch.bodies(a, b)) continue;
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
    now.validity.move(motions_.of_bodies(pair.first, pair.second));
  }
  for (const NearPair& gone : pairs_)
    for (const std::uint32_t listed : gone.groups.listed) unused_ += listed;
  pairs_.swap(next_);
}

/// Finds the near clusters of pairs that have no valid list of them.
void EdgeQuery::pair_clusters(const Frame& frame) {
  unlisted_.clear();
  make_room(unlisted_, pairs_.size());
  for (const std::size_t i : order_) {
    NearPair& pair = pairs_[i];
    if (keeps_lists_ && pair.validity.is_valid()) continue;
    const double room = margin_of_list(pair.validity.usual, most_room(pair));
    pair.validity.moved = 0.0;
    pair.validity.room = room;
    const Box common = common_part(grown(motions_.box_of_body(pair.bodies.first), room),
                                   grown(motions_.box_of_body(pair.bodies.second), room));
    unlisted_.push_back({pair.bodies, common, room, static_cast<Index>(i)});
  }
  const std::span<ClusterPairs::Found> facing = clusters_.find(frame.threads, motions_.boxes(), unlisted_);
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
  groups_.resize(facing.size());
  ClusterGroups& old = pair.groups;
  std::size_t row = 0;
  for (std::size_t i = 0; i < facing.size(); ++i) {
    const IndexPair& clusters = facing[i].clusters;
    for (; row < old.size() && old.clusters(row) < clusters; ++row) unused_ += old.listed[row];
    if (keeps_lists_ && row < old.size() && old.clusters(row) == clusters) {
      groups_.set(i, old, row++);
    } else {
      groups_.set(i, clusters);
    }
  }
  for (; row < old.size(); ++row) unused_ += old.listed[row];
  old.copy(groups_);
  if (pair.first >= old.size()) pair.first = 0;
}

void EdgeQuery::find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const PairFilter& may_touch, const ContactTable& contacts, const Deadline& deadline) {
  is_timed_ = deadline.exists();
  work_.all = work_.late = 0;
  work_.late_pairs.clear();
  motions_.follow(threads, positions, may_touch);
  const double unit = power_of_two(motions_.largest_side());
  const Frame frame{threads,
                    bodies,
                    positions,
                    may_touch,
                    contacts,
                    deadline,
                    {bodies, surface_, blocks_, positions, motions_.boxes(), unit}};
  pair_bodies(frame);
  order_pairs();
  pair_clusters(frame);
  free_lost(frame);
  choose_tasks(frame);
  list_groups(frame);
  test_groups(frame);
  std::ranges::sort(found_, {}, [](const EdgeTriangle& hit) { return std::pair(hit.edge, hit.triangle); });
  leave_out_tasks();
  end_pairs(bodies);
}

}  // namespace palpate

#include "contact/edge_query.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "contact/layers.hpp"
#include "contact/rim_falloff.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t clusters_of_chunk = 64;
constexpr std::size_t groups_of_chunk = 64;
constexpr std::size_t facing_of_chunk = 32;
/// The largest margin of a list, over the reach of a rim.
constexpr double most_room = 0.4;
/// Factor above the rounding error of the sum of a few numbers.
constexpr double rounding = 1.0 + 1e-12;

/// The largest power of two that is not above a length; 1 for no length.
double power_of_two(double size) {
  return size > 0.0 ? std::ldexp(1.0, std::ilogb(size)) : 1.0;
}

}  // namespace

struct EdgeQuery::Frame {
  const parallel::Threads& threads;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const PairFilter& may_touch;
  const ContactTable& contacts;
  const Deadline& deadline;
  FacingClusters::Frame facing;

  [[nodiscard]] bool has_end_in_contact(Index edge, Index body) const {
    const Edge& ends = at(bodies.edges(), edge);
    return contacts.find(ends[0], body) >= 0 || contacts.find(ends[1], body) >= 0;
  }
};

EdgeQuery::EdgeQuery(const Bodies& bodies)
    : surface_(bodies),
      blocks_(surface_, bodies),
      clusters_(surface_),
      boxes_(surface_.clusters.clusters.size()),
      motions_(boxes_.size()),
      bodies_(bodies.bodies().size()) {
  for (Index b = 0; b < bodies.body_count(); ++b) most_room_.push_back(most_room * rim_reach(bodies, b));
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
    now.usual = std::max(last, 0.5 * now.usual);
    now.moved = rounding * (now.moved + last);
  }
  pairs_.swap(next_);
}

/// Lists near edges of pairs that have no list, or have moved further than its margin.
void EdgeQuery::list_again(const Frame& frame) {
  unlisted_.clear();
  make_room(unlisted_, pairs_.size());
  for (const std::size_t i : order_) {
    NearPair& pair = pairs_[i];
    ++pair.served;
    pair.is_late = false;
    if (std::exchange(pair.is_partial, false)) pair.room = 0.0;
    if (pair.room > 0.0 && pair.moved <= pair.room) continue;
    pair.room = room_for(pair);
    pair.moved = 0.0;
    pair.served = 0;
    pair.groups.clear();
    pair.near.clear();
    const Box common = common_part(grown(at(bodies_, pair.bodies.first).box, pair.room),
                                   grown(at(bodies_, pair.bodies.second).box, pair.room));
    unlisted_.push_back({pair.bodies, common, pair.room, static_cast<Index>(i)});
  }
  facing_ = clusters_.find(frame.threads, boxes_, unlisted_);
  rotate_clusters();
  listing_.begin(frame.deadline, facing_.size(), facing_of_chunk);
  resize_with_room(fresh_begin_, facing_.size() + 1);
  fresh_begin_[0] = 0;
  near_lists_.fill(frame.threads, facing_.size(), facing_of_chunk,
                   [&](std::size_t begin, std::size_t end, std::vector<NearEdge>& found) {
                     if (listing_.skips(begin)) {
                       for (std::size_t i = begin; i < end; ++i) fresh_begin_[i + 1] = 0;
                       return;
                     }
                     FacingClusters facing(frame.facing);
                     for (std::size_t i = begin; i < end; ++i) {
                       const std::size_t before = found.size();
                       list(frame, facing_[i], facing, found);
                       fresh_begin_[i + 1] = found.size() - before;
                     }
                   });
  leave_out_clusters();
  std::partial_sum(fresh_begin_.begin(), fresh_begin_.end(), fresh_begin_.begin());
  near_lists_.make_even_room();
  near_lists_.join(near_);
}

/// Lists the near edges of two clusters.
void EdgeQuery::list(const Frame& frame, const ClusterPairs::Found& pair, FacingClusters& facing,
                     std::vector<NearEdge>& found) const {
  const auto& [a, b] = pair.clusters;
  facing.face(a, b);
  const double room = at(pairs_, pair.number).room;
  // Contacts of the next detections may be others, so a list that is kept has all edges.
  const auto wanted = [&](std::size_t side, std::size_t place) {
    if (room > 0.0) return true;
    const Index body = at(surface_.clusters.clusters, side == 0 ? b : a).body;
    const Index first = at(surface_.edges.begin, side == 0 ? a : b);
    return !frame.has_end_in_contact(at(surface_.edges.values, first + static_cast<Index>(place)), body);
  };
  facing.list(room, wanted, found);
}

/// Gives pairs with a margin their lists.
void EdgeQuery::take_lists() {
  for (std::size_t i = 0; i < facing_.size(); ++i) {
    NearPair& pair = at(pairs_, facing_[i].number);
    const std::span<const NearEdge> fresh =
        std::span(near_).subspan(fresh_begin_[i], fresh_begin_[i + 1] - fresh_begin_[i]);
    if (pair.room == 0.0 || fresh.empty()) continue;
    make_room(pair.groups, pair.groups.size() + 1);
    make_room(pair.near, pair.near.size() + fresh.size());
    pair.groups.push_back({facing_[i].clusters, pair.near.size(), fresh.size(), 0.0, -1.0F});
    pair.near.insert(pair.near.end(), fresh.begin(), fresh.end());
  }
}

Index EdgeQuery::edge_of(const IndexPair& clusters, const NearEdge& near) const {
  const Index cluster = near.side == 0 ? clusters.first : clusters.second;
  return at(surface_.edges.values, at(surface_.edges.begin, cluster) + near.place);
}

/// Whether an edge meets a triangle of its own body only because tissue there is inverted or flat.
bool EdgeQuery::is_folded(const Frame& frame, const Edge& ends, Index triangle) {
  if (frame.bodies.body_of(ends) != frame.bodies.body_of(at(frame.bodies.triangles(), triangle)))
    return false;
  const Index tet = at(frame.bodies.triangle_tets(), triangle);
  return std::ranges::any_of(ends,
                             [&](Index end) { return is_fold(frame.bodies, frame.positions, end, tet); });
}

/// The cluster of the triangles near an edge.
const Cluster& EdgeQuery::faced_by(const IndexPair& clusters, const NearEdge& near) const {
  return at(surface_.clusters.clusters, near.side == 0 ? clusters.second : clusters.first);
}

void EdgeQuery::test_exactly(const Frame& frame, const IndexPair& clusters, const NearEdge& near,
                             std::vector<EdgeTriangle>& found) const {
  const Index edge = edge_of(clusters, near);
  const Edge& ends = at(frame.bodies.edges(), edge);
  const std::span<const Index> triangles = surface_.clusters.primitives_of(faced_by(clusters, near));
  for (std::uint32_t left = near.touching; left != 0; left &= left - 1) {
    const Index triangle = triangles[static_cast<std::size_t>(std::countr_zero(left))];
    const std::array<Vec3, 3> x = corners_of(frame.positions, at(frame.bodies.triangles(), triangle));
    if (segment_meets_triangle(at(frame.positions, ends[0]), at(frame.positions, ends[1]), x[0], x[1],
                               x[2]) &&
        !is_folded(frame, ends, triangle))
      found.push_back({edge, triangle});
  }
}

/// The pairs without a list.
void EdgeQuery::test_fresh(const Frame& frame) {
  const std::size_t chunks = parallel::chunk_count(facing_.size(), facing_of_chunk);
  lists_.make_room_in_all(chunks + chunks / 2 + 1, 4 * facing_of_chunk);
  lists_.fill(frame.threads, facing_.size(), facing_of_chunk,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                for (std::size_t i = begin; i < end; ++i) {
                  if (at(pairs_, facing_[i].number).room > 0.0) continue;
                  for (std::size_t near = fresh_begin_[i]; near < fresh_begin_[i + 1]; ++near) {
                    if (near_[near].touching != 0)
                      test_exactly(frame, facing_[i].clusters, near_[near], found);
                  }
                }
              });
  lists_.join(found_);
}

void EdgeQuery::test_group(const Frame& frame, NearPair& pair, Group& group, FacingClusters& facing,
                           std::vector<EdgeTriangle>& found) const {
  const auto& [a, b] = group.clusters;
  // Pairs that were listed now have not moved since.
  if (group.moved == unknown_motion) {
    group.moved = pair.moved;
  } else if (pair.moved > 0.0)
    group.moved = rounding * (group.moved + furthest(at(motions_, a), at(motions_, b)));
  if (group.moved < static_cast<double>(group.apart)) return;
  bool faces = false;
  group.apart = std::numeric_limits<float>::max();
  for (NearEdge& near : std::span(pair.near).subspan(group.begin, group.size)) {
    const bool again = pair.moved > 0.0 && !(group.moved < static_cast<double>(near.apart));
    if (again || near.touching != 0) {
      if (frame.has_end_in_contact(edge_of(group.clusters, near), faced_by(group.clusters, near).body)) {
        group.apart = -1.0F;  // it may be without a contact in the next detection
        continue;
      }
      if (again) {
        if (!std::exchange(faces, true)) facing.face(a, b);
        facing.test_again(near);
        constexpr double down = 1.0 - 1e-6;
        if (near.apart > 0.0F)
          near.apart = static_cast<float>(down * (group.moved + static_cast<double>(near.apart)));
      }
      test_exactly(frame, group.clusters, near, found);
    }
    group.apart = std::min(group.apart, near.apart);
  }
}

/// The pairs with a list.
void EdgeQuery::test_listed(const Frame& frame) {
  begin_.clear();
  make_room(begin_, pairs_.size() + 1);
  begin_.push_back(0);
  for (const std::size_t i : order_) begin_.push_back(begin_.back() + pairs_[i].groups.size());
  testing_.begin(frame.deadline, begin_.back(), groups_of_chunk);
  const std::size_t chunks = parallel::chunk_count(begin_.back(), groups_of_chunk);
  lists_.make_room_in_all(chunks + chunks / 2 + 1, 4 * groups_of_chunk);
  lists_.fill(frame.threads, begin_.back(), groups_of_chunk,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                if (testing_.skips(begin)) return;
                FacingClusters facing(frame.facing);
                auto place =
                    static_cast<std::size_t>(std::ranges::upper_bound(begin_, begin) - begin_.begin()) - 1;
                for (std::size_t group = begin; group < end; ++group) {
                  while (group >= begin_[place + 1]) ++place;
                  NearPair& pair = pairs_[order_[place]];
                  test_group(frame, pair, pair.groups[group - begin_[place]], facing, found);
                }
              });
  lists_.append(found_, chunks);
  leave_out_groups();
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
  list_again(frame);
  take_lists();
  make_room(found_, contacts.size());
  test_fresh(frame);
  test_listed(frame);
  std::ranges::sort(found_, {}, [](const EdgeTriangle& hit) { return std::pair(hit.edge, hit.triangle); });
  end_pairs(bodies);
}

}  // namespace palpate

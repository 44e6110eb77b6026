// The lists of near edges of two clusters, and the tests of these edges.
#include <algorithm>
#include <array>
#include <bit>
#include <bitset>
#include <limits>
#include <utility>

#include "contact/edge_query_frame.hpp"
#include "contact/layers.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t groups_of_chunk = 256;
constexpr std::size_t listed_of_chunk = 32;
constexpr std::size_t tested_of_chunk = 64;
constexpr std::size_t most_edges_of_cluster = 3 * Cluster::most_primitives;
/// The largest margin of a list of edges, over that of a list of clusters.
constexpr double edges_over_clusters = 0.5;

}  // namespace

/// Moves all groups, and finds those to list or to test.
void EdgeQuery::choose_tasks(const Frame& frame) {
  begin_.clear();
  make_room(begin_, pairs_.size() + 1);
  begin_.push_back(0);
  for (const std::size_t i : order_) begin_.push_back(begin_.back() + pairs_[i].groups.size());
  task_lists_.fill(
      frame.threads, begin_.back(), groups_of_chunk,
      [&](std::size_t begin, std::size_t end, std::vector<Task>& tasks) {
        auto place = static_cast<std::size_t>(std::ranges::upper_bound(begin_, begin) - begin_.begin() - 1);
        for (std::size_t from = begin; from < end; ++place) {
          const std::size_t to = std::min(end, begin_[place + 1]);
          choose(order_[place], {from - begin_[place], to - begin_[place]}, tasks);
          from = to;
        }
      });
  task_lists_.make_even_room();
  task_lists_.join(tasks_);
}

/// Moves some groups of a pair: those at `places` in the order of the search.
void EdgeQuery::choose(std::size_t number, const std::pair<std::size_t, std::size_t>& places,
                       std::vector<Task>& tasks) {
  NearPair& pair = pairs_[number];
  const bool is_own = pair.bodies.first == pair.bodies.second;
  for (std::size_t place = places.first; place < places.second; ++place) {
    const std::size_t i = place + pair.first < pair.groups.size() ? place + pair.first
                                                                  : place + pair.first - pair.groups.size();
    Group& group = pair.groups[i];
    const auto& [a, b] = group.clusters;
    group.validity.move(motions_.of_clusters(a, b, is_own));
    const bool is_listed = group.validity.is_valid();
    if (!is_listed || !(group.validity.moved < static_cast<double>(group.apart)))
      tasks.push_back({number, i, is_listed});
  }
}

/// Lists the near edges of groups that have no valid list.
void EdgeQuery::list_groups(const Frame& frame) {
  to_list_.clear();
  make_room(to_list_, tasks_.size());
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    if (tasks_[i].is_listed) continue;
    to_list_.push_back(i);
    unused_ += std::exchange(group_of(tasks_[i]).size, 0);
  }
  drop_unused();
  listing_.begin(frame.deadline, to_list_.size(), listed_of_chunk);
  near_lists_.fill(frame.threads, to_list_.size(), listed_of_chunk,
                   [&](std::size_t begin, std::size_t end, std::vector<NearEdge>& found) {
                     if (listing_.skips(begin)) return;
                     FacingClusters facing(frame.facing);
                     for (std::size_t i = begin; i < end; ++i) {
                       Task& task = tasks_[to_list_[i]];
                       list(pairs_[task.pair], group_of(task), facing, found);
                       task.is_listed = true;
                     }
                   });
  near_lists_.make_even_room();
  take_lists();
}

void EdgeQuery::list(const NearPair& pair, Group& group, FacingClusters& facing,
                     std::vector<NearEdge>& found) const {
  const auto& [a, b] = group.clusters;
  const std::size_t before = found.size();
  Validity& validity = group.validity;
  const double between = gap(at(motions_.boxes(), a), at(motions_.boxes(), b));
  if (between > validity.usual) {
    validity.moved = 0.0;
    validity.room = between;
    group.apart = std::numeric_limits<float>::max();
  } else {
    facing.face(a, b);
    facing.list(validity.renew(edges_over_clusters * most_room(pair)), found);
    group.apart = -1.0F;
  }
  group.size = found.size() - before;
}

/// Stores the new lists.
void EdgeQuery::take_lists() {
  std::size_t begin = near_.size();
  std::size_t size = begin;
  for (const std::size_t i : to_list_) size += group_of(tasks_[i]).size;
  if (near_.capacity() < size) {  // so that only the first searches allocate
    make_room(near_, 2 * size);
    make_room(kept_, near_.capacity());
  }
  near_lists_.append(near_, parallel::chunk_count(to_list_.size(), listed_of_chunk));
  for (const std::size_t i : to_list_) {
    if (!tasks_[i].is_listed) continue;
    Group& group = group_of(tasks_[i]);
    group.begin = begin;
    begin += group.size;
  }
}

/// Moves lists together when half of all items belong to none.
void EdgeQuery::drop_unused() {
  if (2 * unused_ <= near_.size()) return;
  kept_.clear();
  for (NearPair& pair : pairs_) {
    for (Group& group : pair.groups) {
      const std::size_t begin = std::exchange(group.begin, kept_.size());
      const auto list = std::span(near_).subspan(begin, group.size);
      kept_.insert(kept_.end(), list.begin(), list.end());
    }
  }
  near_.swap(kept_);
  unused_ = 0;
}

/// What near edges of two clusters refer to: [side].
struct EdgeQuery::Sides {
  Sides(const SurfaceClusters& surface, const IndexPair& clusters) {
    const auto& [a, b] = clusters;
    const Cluster& first = at(surface.clusters.clusters, a);
    const Cluster& second = at(surface.clusters.clusters, b);
    edges = {surface.edges[a], surface.edges[b]};
    faced = {surface.clusters.primitives_of(second), surface.clusters.primitives_of(first)};
    faced_body = {second.body, first.body};
  }
  std::array<std::span<const Index>, 2> edges;
  std::array<std::span<const Index>, 2> faced;  ///< triangles
  std::array<Index, 2> faced_body{};
};

/// Whether an edge meets a triangle of its own body only because tissue there is inverted or flat.
bool EdgeQuery::is_folded(const Frame& frame, const Edge& ends, Index triangle) {
  if (frame.bodies.body_of(ends) != frame.bodies.body_of(at(frame.bodies.triangles(), triangle)))
    return false;
  const Index tet = at(frame.bodies.triangle_tets(), triangle);
  return std::ranges::any_of(ends,
                             [&](Index end) { return is_fold(frame.bodies, frame.positions, end, tet); });
}

void EdgeQuery::test_exactly(const Frame& frame, const Sides& sides, const NearEdge& near,
                             std::vector<EdgeTriangle>& found) {
  const Index edge = sides.edges[near.side][near.place];
  const Edge& ends = at(frame.bodies.edges(), edge);
  const std::span<const Index> triangles = sides.faced[near.side];
  for (std::uint32_t left = near.touching; left != 0; left &= left - 1) {
    const Index triangle = triangles[static_cast<std::size_t>(std::countr_zero(left))];
    const std::array<Vec3, 3> x = corners_of(frame.positions, at(frame.bodies.triangles(), triangle));
    if (segment_meets_triangle(at(frame.positions, ends[0]), at(frame.positions, ends[1]), x[0], x[1],
                               x[2]) &&
        !is_folded(frame, ends, triangle))
      found.push_back({edge, triangle});
  }
}

void EdgeQuery::test_groups(const Frame& frame) {
  testing_.begin(frame.deadline, tasks_.size(), tested_of_chunk);
  const std::size_t chunks = parallel::chunk_count(tasks_.size(), tested_of_chunk);
  lists_.make_room_in_all(chunks + chunks / 2 + 1, 4 * tested_of_chunk);
  lists_.fill(frame.threads, tasks_.size(), tested_of_chunk,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                if (testing_.skips(begin)) return;
                FacingClusters facing(frame.facing);
                for (std::size_t i = begin; i < end; ++i)
                  if (tasks_[i].is_listed) test(frame, group_of(tasks_[i]), facing, found);
              });
  make_room(found_, frame.contacts.size());
  lists_.join(found_);
}

/// Tests the edges of a group that may touch their near triangles.
void EdgeQuery::test(const Frame& frame, Group& group, FacingClusters& facing,
                     std::vector<EdgeTriangle>& found) {
  const std::span<NearEdge> edges = std::span(near_).subspan(group.begin, group.size);
  const Sides sides(surface_, group.clusters);
  const double moved = group.validity.moved;
  // What was listed now has not moved since, so that none is nearer than this.
  const double nearest = moved > 0.0 ? moved : -1.0;
  float apart = std::numeric_limits<float>::max();
  std::array<NearEdge*, 2 * most_edges_of_cluster> tested;
  std::size_t size = 0;
  std::bitset<2 * most_edges_of_cluster> is_moved;
  for (NearEdge& near : edges) {
    const bool again = !(nearest < static_cast<double>(near.apart));
    if (!again && near.touching == 0) {
      apart = std::min(apart, near.apart);
      continue;
    }
    if (frame.has_end_in_contact(sides.edges[near.side][near.place], sides.faced_body[near.side])) {
      apart = -1.0F;  // it may be without a contact in the next detection
      continue;
    }
    if (again) {
      if (is_moved.none()) facing.face(group.clusters.first, group.clusters.second);
      is_moved.set(size);
      facing.test_again(near);
    }
    tested[size++] = &near;
  }
  if (is_moved.any()) facing.finish();
  for (std::size_t i = 0; i < size; ++i) {
    NearEdge& near = *tested[i];
    constexpr double down = 1.0 - 1e-6;
    if (is_moved[i] && near.apart > 0.0F)
      near.apart = static_cast<float>(down * (moved + static_cast<double>(near.apart)));
    apart = std::min(apart, near.apart);
    test_exactly(frame, sides, near, found);
  }
  group.apart = apart;
}

}  // namespace palpate

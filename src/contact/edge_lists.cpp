// The lists of near edges of two clusters, and the tests of these edges.
#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "contact/edge_query_frame.hpp"
#include "contact/layers.hpp"
#include "geometry/predicates.hpp"
#include "geometry/triangle.hpp"
#include "room.hpp"
#include "simd/reached_pairs.hpp"

namespace palpate {
namespace {

constexpr std::size_t groups_of_chunk = 256;
constexpr std::size_t listed_of_chunk = 32;
/// Groups that are listed before their lists are stored. It bounds the scratch memory.
constexpr std::size_t listed_at_once = 32 * listed_of_chunk;
constexpr std::size_t tested_of_chunk = 64;
/// The largest margin of a list of edges, over that of a list of clusters.
constexpr double edges_over_clusters = 0.25;
/// Stored pairs for each cluster, from which on lists have no margin: everything is near everything, as in
/// bodies of long thin tets, and lists with a margin would need memory for all pairs.
constexpr std::size_t crowded = 640;
/// Stored pairs, all together, from which on lists have no margin while no motion is known: a single
/// detection of a large scene needs no memory for them.
constexpr std::size_t most_at_first = std::size_t{1} << 18;
/// NearEdges::apart of a pair with an end in contact with the other body.
constexpr float apart_by_contact = std::numeric_limits<float>::infinity();

}  // namespace

/// Where points have lost contacts, pairs that were left out because of contacts are to be tested.
void EdgeQuery::free_lost(const Frame& frame) {
  lost_.follow(frame.bodies, frame.contacts);
  for (const IndexPair& bodies : lost_.bodies()) {
    const auto pair = std::ranges::lower_bound(pairs_, bodies, {}, &NearPair::bodies);
    if (pair == pairs_.end() || pair->bodies != bodies) continue;
    ClusterGroups& groups = pair->groups;
    parallel::for_each(frame.threads, groups.size(), groups_of_chunk, [&](std::size_t i) {
      const auto [a, b] = groups.clusters(i);
      if (!lost_.has_lost(a) && !lost_.has_lost(b)) return;
      const auto list = std::span(near_.apart).subspan(groups.begin[i], groups.listed[i]);
      std::ranges::replace(list, apart_by_contact, 0.0F);
      groups.apart[i] = 0.0F;
    });
  }
}

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
  task_lists_.join(frame.threads, tasks_);
}

/// Moves some groups of a pair: those at `places` in the order of the search.
void EdgeQuery::choose(std::size_t number, const std::pair<std::size_t, std::size_t>& places,
                       std::vector<Task>& tasks) {
  NearPair& pair = pairs_[number];
  ClusterGroups& groups = pair.groups;
  const bool is_own = pair.bodies.first == pair.bodies.second;
  std::array<std::int32_t, groups_of_chunk + Cluster::most_primitives> due;
  for (std::size_t place = places.first; place < places.second;) {
    const std::size_t wrapped = place + pair.first;
    const std::size_t begin = wrapped < groups.size() ? wrapped : wrapped - groups.size();
    const std::size_t end = std::min(groups.size(), begin + places.second - place);
    const std::size_t found =
        simd::move_pairs(motions_.of_clusters(is_own), groups.moving(), begin, end, due.data());
    for (const std::int32_t i : std::span(due).first(found)) {
      const auto group = static_cast<std::size_t>(i);
      tasks.push_back({number, group, groups.is_listed(group)});
    }
    place += end - begin;
  }
}

/// Lists the near edges of groups that have no valid list.
void EdgeQuery::list_groups(const Frame& frame) {
  to_list_.clear();
  make_room(to_list_, tasks_.size());
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    if (tasks_[i].is_listed) continue;
    to_list_.push_back(i);
    unused_ += std::exchange(pairs_[tasks_[i].pair].groups.listed[tasks_[i].group], 0);
  }
  drop_unused();
  listing_.begin(frame.deadline, to_list_.size(), listed_of_chunk);
  for (std::size_t from = 0; from < to_list_.size(); from += listed_at_once) {
    list_some(frame, std::span(to_list_).subspan(from, std::min(listed_at_once, to_list_.size() - from)),
              from);
  }
}

/// \param tasks  some of `to_list_`, from the one with number `first` on
void EdgeQuery::list_some(const Frame& frame, std::span<const std::size_t> tasks, std::size_t first) {
  near_lists_.fill(frame.threads, tasks.size(), listed_of_chunk,
                   [&](std::size_t begin, std::size_t end, std::vector<NearEdge>& found) {
                     if (listing_.skips(first + begin)) return;
                     FacingClusters facing(frame.surface);
                     for (const std::size_t i : tasks.subspan(begin, end - begin)) {
                       list(tasks_[i], facing, found);
                       tasks_[i].is_listed = true;
                     }
                   });
  take_lists(frame.threads, tasks);
}

void EdgeQuery::list(const Task& task, FacingClusters& facing, std::vector<NearEdge>& found) {
  const NearPair& pair = pairs_[task.pair];
  ClusterGroups& groups = pairs_[task.pair].groups;
  const std::size_t i = task.group;
  const auto [a, b] = groups.clusters(i);
  const std::size_t before = found.size();
  const auto usual = static_cast<double>(groups.usual[i]);
  double room = gap(at(motions_.boxes(), a), at(motions_.boxes(), b));
  groups.moved[i] = 0.0F;
  groups.apart[i] = std::numeric_limits<float>::max();
  if (!(room > usual)) {
    const std::size_t most_pairs = usual == 0.0 ? most_at_first : crowded * motions_.boxes().size();
    room = near_.size() > most_pairs ? 0.0 : margin_of_list(usual, edges_over_clusters * most_room(pair));
    facing.list(a, b, room, found);
    groups.apart[i] = 0.0F;
  }
  constexpr double down = 1.0 - 1e-6;  // for the rounding to float
  // An infinite margin would be valid after an infinite motion.
  constexpr double most = std::numeric_limits<float>::max();
  groups.room[i] = static_cast<float>(std::min(down * room, most));
  groups.listed[i] = static_cast<std::uint32_t>(found.size() - before);
}

/// Stores the new lists.
void EdgeQuery::take_lists(const parallel::Threads& threads, std::span<const std::size_t> tasks) {
  std::size_t begin = near_.size();
  const std::size_t chunks = parallel::chunk_count(tasks.size(), listed_of_chunk);
  std::array<std::size_t, listed_at_once / listed_of_chunk> places;
  std::size_t size = 0;
  std::size_t longest = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    places[chunk] = begin + size;
    size += near_lists_.list(chunk).size();
    longest = std::max(longest, near_lists_.list(chunk).size());
  }
  if (!near_.has_room(size)) {  // so that only the first searches allocate
    near_.make_room(2 * (begin + size));
    kept_.make_room(2 * (begin + size));
  }
  near_.grow(size);
  parallel::for_each(threads, chunks, 4,
                     [&](std::size_t chunk) { near_.put(places[chunk], near_lists_.list(chunk)); });
  if (longest > longest_list_) longest_list_ = 2 * longest;
  constexpr std::size_t most_chunks = listed_at_once / listed_of_chunk;
  near_lists_.make_room_in_all(std::min(chunks + chunks / 2 + 4, most_chunks), longest_list_);
  for (const std::size_t i : tasks) {
    if (!tasks_[i].is_listed) continue;
    ClusterGroups& groups = pairs_[tasks_[i].pair].groups;
    groups.begin[tasks_[i].group] = static_cast<std::uint32_t>(begin);
    begin += groups.listed[tasks_[i].group];
  }
}

/// Moves lists together when half of all items belong to none.
void EdgeQuery::drop_unused() {
  if (2 * unused_ <= near_.size()) return;
  kept_.clear();
  for (NearPair& pair : pairs_) {
    for (std::size_t i = 0; i < pair.groups.size(); ++i) {
      const auto begin = std::exchange(pair.groups.begin[i], static_cast<std::uint32_t>(kept_.size()));
      kept_.append(near_, begin, pair.groups.listed[i]);
    }
  }
  near_.swap(kept_);
  unused_ = 0;
}

/// Whether an edge meets a triangle of its own body only because tissue there is inverted or flat.
bool EdgeQuery::is_folded(const Frame& frame, const EdgeTriangle& pair) {
  const Edge& ends = at(frame.bodies.edges(), pair.edge);
  const Index tet = at(frame.bodies.triangle_tets(), pair.triangle);
  return std::ranges::any_of(ends,
                             [&](Index end) { return is_fold(frame.bodies, frame.positions, end, tet); });
}

/// Tests pairs of a chunk of groups that may meet.
class EdgeQuery::Tests {
 public:
  Tests(const Frame& frame, NearEdges& near, std::vector<EdgeTriangle>& found)
      : frame_(frame), near_(near), found_(found), waiting_(frame.surface) {}

  void test(const IndexPair& bodies, ClusterGroups& groups, std::size_t group) {
    float& apart = groups.apart[group];
    apart = std::numeric_limits<float>::max();
    const float moved = groups.moved[group];
    const std::size_t end = groups.begin[group] + groups.listed[group];
    std::array<std::int32_t, most_at_once + Cluster::most_primitives> reached;
    for (std::size_t begin = groups.begin[group]; begin < end; begin += most_at_once) {
      const simd::ReachedPairs found = simd::find_reached(
          {&near_.apart[begin], std::min(most_at_once, end - begin)}, moved, apart, reached.data());
      apart = std::min(apart, found.least);
      if (found.size == 0) continue;
      if (!waiting_.has_room(found.size)) finish();
      const std::size_t before = waiting_.size();
      for (const std::int32_t i : std::span(reached).first(found.size)) {
        const std::size_t place = begin + static_cast<std::size_t>(i);
        if (frame_.has_end_in_contact(near_.edge[place], bodies)) {
          near_.apart[place] = apart_by_contact;
          continue;
        }
        places_[waiting_.add(near_.edge[place], near_.triangle[place])] = place;
      }
      if (waiting_.size() > before) {
        parts_[part_count_++] = {waiting_.size(), moved, bodies.first == bodies.second, &apart};
      }
    }
  }
  void finish() {
    const Part* part = parts_.data();
    waiting_.test([&](std::size_t number, const EdgeTriangle& pair, float gap) {
      while (number == part->end) ++part;
      constexpr float down = 1.0F - 1e-6F;  // for the rounding of the sum
      const float apart = gap > 0.0F ? down * (part->moved + gap) : 0.0F;
      near_.apart[places_[number]] = apart;
      *part->apart = std::min(*part->apart, apart);
      if (gap > 0.0F || (!(gap < 0.0F) && !meet(pair)) || (part->is_own && is_folded(frame_, pair))) return;
      if (!part->is_own && are_tied(pair)) return;
      found_.push_back(pair);
    });
    part_count_ = 0;
  }

 private:
  static constexpr std::size_t most_at_once = simd::EdgeTrianglePairs::most;
  /// Waiting pairs of a group.
  struct Part {
    std::size_t end;  ///< their numbers are below
    float moved;      ///< by the clusters, m
    bool is_own;      ///< of one body
    float* apart;     ///< of the group
  };
  [[nodiscard]] bool meet(const EdgeTriangle& pair) const {
    const Edge& ends = at(frame_.bodies.edges(), pair.edge);
    const std::array<Vec3, 3> x = corners_of(frame_.positions, at(frame_.bodies.triangles(), pair.triangle));
    return segment_meets_triangle(at(frame_.positions, ends[0]), at(frame_.positions, ends[1]), x[0], x[1],
                                  x[2]);
  }
  [[nodiscard]] bool are_tied(const EdgeTriangle& pair) const {
    const Bodies& bodies = frame_.bodies;
    const Edge& ends = at(bodies.edges(), pair.edge);
    const Triangle& corners = at(bodies.triangles(), pair.triangle);
    return frame_.may_touch.are_tied(bodies.body_of(ends), ends, bodies.body_of(corners), corners);
  }

  const Frame& frame_;
  NearEdges& near_;
  std::vector<EdgeTriangle>& found_;
  WaitingPairs waiting_;
  std::array<std::size_t, most_at_once> places_;  ///< of the waiting pairs in the lists
  std::array<Part, most_at_once> parts_;
  std::size_t part_count_ = 0;
};

void EdgeQuery::test_groups(const Frame& frame) {
  testing_.begin(frame.deadline, tasks_.size(), tested_of_chunk);
  const std::size_t chunks = parallel::chunk_count(tasks_.size(), tested_of_chunk);
  lists_.make_room_in_all(chunks + chunks / 2 + 1, 4 * tested_of_chunk);
  lists_.fill(frame.threads, tasks_.size(), tested_of_chunk,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                if (testing_.skips(begin)) return;
                Tests tests(frame, near_, found);
                for (const Task& task : std::span(tasks_).subspan(begin, end - begin)) {
                  NearPair& pair = pairs_[task.pair];
                  if (task.is_listed) tests.test(pair.bodies, pair.groups, task.group);
                }
                tests.finish();
              });
  make_room(found_, frame.contacts.size());
  lists_.join(frame.threads, found_);
}

}  // namespace palpate

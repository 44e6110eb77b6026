#include "contact/swept_query.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

#include "contact/swept_frame.hpp"
#include "contact/swept_pair.hpp"
#include "geometry/axis.hpp"
#include "geometry/box.hpp"
#include "geometry/triangle.hpp"
#include "mesh/outward.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t swept_cluster_grain = 64;
constexpr std::size_t swept_pair_grain = 16;
constexpr std::size_t most_edges = 3 * Cluster::most_primitives;

/// Primitives of one cluster that may touch the other cluster of a pair, with their boxes in its frame.
template <std::size_t most>
class Near {
 public:
  void add(Index primitive, const Box& box) {
    primitives_[size_] = primitive;
    boxes_[size_++] = box;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] Index primitive(std::size_t i) const { return primitives_[i]; }
  [[nodiscard]] const Box& box(std::size_t i) const { return boxes_[i]; }

 private:
  std::array<Index, most> primitives_;
  std::array<Box, most> boxes_;
  std::size_t size_ = 0;
};

/// Calls take(a, b) for all primitives whose boxes meet.
template <std::size_t m, std::size_t n, class Take>
void for_each_meeting(const Near<m>& first, const Near<n>& second, Take&& take) {
  for (std::size_t i = 0; i < first.size(); ++i) {
    for (std::size_t j = 0; j < second.size(); ++j)
      if (first.box(i).overlaps(second.box(j))) take(first.primitive(i), second.primitive(j));
  }
}

Vec3 middle(const Box& box) {
  return 0.5 * (box.lower + box.upper);
}

template <class A, class B>
bool have_common_point(const A& a, const B& b) {
  return std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

template <class A, class B>
SweptPoints points_of(std::span<const Vec3> start, std::span<const Vec3> end, const A& a, const B& b) {
  SweptPoints points;
  std::size_t i = 0;
  const auto add = [&](Index p) {
    points.start[i] = at(start, p);
    points.end[i++] = at(end, p);
  };
  for (const Index p : a) add(p);
  for (const Index p : b) add(p);
  return points;
}

}  // namespace

SweptQuery::SweptQuery(const Bodies& bodies)
    : bodies_(bodies),
      surface_(bodies),
      thickness_(bodies, surface_.clusters),
      clusters_(surface_.clusters.clusters.size()),
      of_bodies_(bodies.bodies().size()),
      marked_(clusters_.size(), 0) {}

std::span<const SweptContact> SweptQuery::find(const parallel::Threads& threads, std::span<const Vec3> start,
                                               std::span<const Vec3> end, const PairFilter& filter,
                                               const SweptSettings& settings) {
  return find(threads, start, start, end, filter, settings);
}

std::span<const SweptContact> SweptQuery::find(const parallel::Threads& threads, std::span<const Vec3> start,
                                               std::span<const Vec3> from, std::span<const Vec3> end,
                                               const PairFilter& filter, const SweptSettings& settings) {
  begin({threads, start, end, filter, settings}, from);
  if (body_pairs_.empty()) return contacts_;
  const Step step{threads, from, end, filter, settings};
  mark_clusters();
  find_cluster_pairs(step);
  count_cluster_pairs();
  test_pairs(step);
  return contacts_;
}

void SweptQuery::count(const parallel::Threads& threads, std::span<const Vec3> start,
                       std::span<const Vec3> end, const PairFilter& filter, const SweptSettings& settings) {
  if (!may_pass(threads, start, end, filter, settings)) return;
  mark_clusters();
  find_cluster_pairs({threads, start, end, filter, settings});
  count_cluster_pairs();
}

bool SweptQuery::may_pass(const parallel::Threads& threads, std::span<const Vec3> start,
                          std::span<const Vec3> end, const PairFilter& filter,
                          const SweptSettings& settings) {
  begin({threads, start, end, filter, settings}, start);
  return !body_pairs_.empty();
}

/// \param from  where the paths begin
void SweptQuery::begin(const Step& step, std::span<const Vec3> from) {
  counts_ = {};
  contacts_.clear();
  sweep_clusters(step);
  if (from.data() != step.start.data()) extend_places(step, from);
  sweep_bodies();
  find_body_pairs(step);
}

/// Boxes grow by rounding errors of positions and by the tolerance, so that touches within it are found, too.
void SweptQuery::sweep_clusters(const Step& step) {
  parallel::for_each(step.threads, clusters_.size(), swept_cluster_grain, [&](std::size_t c) {
    Swept swept;
    for (const Index p : surface_.clusters.points_of(surface_.clusters.clusters[c])) {
      const Vec3& from = at(step.start, p);
      const Vec3& to = at(step.end, p);
      swept.places.extend(from);
      swept.places.extend(to);
      swept.motion.extend(to - from);
    }
    swept.places = grown(swept.places, step.settings.tolerance);
    clusters_[c] = swept;
  });
}

/// Extends the boxes of positions by other positions at the start of the step.
void SweptQuery::extend_places(const Step& step, std::span<const Vec3> from) {
  parallel::for_each(step.threads, clusters_.size(), swept_cluster_grain, [&](std::size_t c) {
    Box places;
    for (const Index p : surface_.clusters.points_of(surface_.clusters.clusters[c]))
      places.extend(at(from, p));
    clusters_[c].places.extend(grown(places, step.settings.tolerance));
  });
}

void SweptQuery::sweep_bodies() {
  for (std::size_t b = 0; b < of_bodies_.size(); ++b) {
    Swept swept;
    const Range& range = surface_.of_body[b];
    for (Index c = range.begin; c < range.end; ++c) {
      swept.places.extend(at(clusters_, c).places);
      swept.motion.extend(at(clusters_, c).motion);
    }
    of_bodies_[b] = swept;
  }
}

bool SweptQuery::may_touch(const PairFilter& filter, Index a, Index b) const {
  const bool one_moves = at(filter.immovable, a) == 0 || at(filter.immovable, b) == 0;
  if (a != b) return one_moves && !filter.ignores(a, b);
  return one_moves && !filter.self_collision.empty() && at(filter.self_collision, a) != 0;
}

/// Sweeps along x to find pairs of bodies; includes a body with itself.
void SweptQuery::find_body_pairs(const Step& step) {
  body_pairs_.clear();
  by_lower_.clear();
  make_room(by_lower_, of_bodies_.size());
  for (Index b = 0; b < bodies_.body_count(); ++b)
    if (at(surface_.of_body, b).size() > 0) by_lower_.push_back(b);
  std::sort(by_lower_.begin(), by_lower_.end(), [&](Index a, Index b) {
    const double low_a = at(of_bodies_, a).places.lower.x;
    const double low_b = at(of_bodies_, b).places.lower.x;
    return low_a != low_b ? low_a < low_b : a < b;
  });
  for (std::size_t i = 0; i < by_lower_.size(); ++i) {
    const Swept& first = at(of_bodies_, by_lower_[i]);
    for (std::size_t j = i; j < by_lower_.size(); ++j) {
      const Index a = std::min(by_lower_[i], by_lower_[j]);
      const Index b = std::max(by_lower_[i], by_lower_[j]);
      const Swept& second = at(of_bodies_, by_lower_[j]);
      if (second.places.lower.x > first.places.upper.x) break;
      if (!first.places.overlaps(second.places)) continue;
      const double thickness = std::min(at(thickness_.of_body, a), at(thickness_.of_body, b));
      if (!(furthest(first.motion, second.motion) > step.settings.least_motion * thickness)) continue;
      if (!may_touch(step.filter, a, b)) continue;
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.push_back({a, b});
    }
  }
  std::sort(body_pairs_.begin(), body_pairs_.end());
}

/// Number of a pair of clusters' bodies in body_pairs_; -1 if it is not there.
std::ptrdiff_t SweptQuery::body_pair_of(const Pair& clusters) const {
  const Index a = at(surface_.clusters.clusters, clusters[0]).body;
  const Index b = at(surface_.clusters.clusters, clusters[1]).body;
  const Pair wanted{std::min(a, b), std::max(a, b)};
  const auto found = std::ranges::lower_bound(body_pairs_, wanted);
  return found != body_pairs_.end() && *found == wanted ? found - body_pairs_.begin() : -1;
}

/// The boxes of bodies meet more often than the bodies, so what could pass is counted by clusters.
void SweptQuery::count_cluster_pairs() {
  counts_.cluster_pairs = pairs_.size();
  assign_with_room(has_clusters_, body_pairs_.size(), std::uint8_t{0});
  for (const Pair& pair : pairs_) {
    at(has_clusters_, body_pair_of(pair)) = 1;
    const double thickness = std::min(at(thickness_.of_cluster, pair[0]), at(thickness_.of_cluster, pair[1]));
    counts_.thinnest = counts_.thinnest > 0.0 ? std::min(counts_.thinnest, thickness) : thickness;
  }
  counts_.body_pairs = static_cast<std::size_t>(std::ranges::count(has_clusters_, 1));
}

/// Marks the clusters that meet the swept box of the other body.
void SweptQuery::mark_clusters() {
  std::fill(marked_.begin(), marked_.end(), 0);
  const auto mark = [&](Index body, Index other) {
    const Box& box = at(of_bodies_, other).places;
    const Range& range = at(surface_.of_body, body);
    for (Index c = range.begin; c < range.end; ++c)
      if (at(clusters_, c).places.overlaps(box)) at(marked_, c) = 1;
  };
  for (const Pair& pair : body_pairs_) {
    mark(pair[0], pair[1]);
    if (pair[0] != pair[1]) mark(pair[1], pair[0]);
  }
}

/// Sweeps along the longest axis of the marked clusters to find pairs of clusters.
void SweptQuery::find_cluster_pairs(const Step& step) {
  by_lower_.clear();
  make_room(by_lower_, clusters_.size());
  Box all;
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    if (marked_[c] == 0) continue;
    by_lower_.push_back(static_cast<Index>(c));
    all.extend(clusters_[c].places);
  }
  const std::size_t axis = longest_axis(all.upper - all.lower);
  const auto lower = [&](Index c) { return along(axis, at(clusters_, c).places.lower); };
  std::sort(by_lower_.begin(), by_lower_.end(),
            [&](Index a, Index b) { return lower(a) != lower(b) ? lower(a) < lower(b) : a < b; });
  pair_lists_.fill(
      step.threads, by_lower_.size(), swept_cluster_grain,
      [&](std::size_t begin, std::size_t end, std::vector<Pair>& list) {
        for (std::size_t i = begin; i < end; ++i) {
          const Index a = by_lower_[i];
          const Swept& first = at(clusters_, a);
          const double upper = along(axis, first.places.upper);
          for (std::size_t j = i; j < by_lower_.size() && lower(by_lower_[j]) <= upper; ++j) {
            const Index b = by_lower_[j];
            const Swept& second = at(clusters_, b);
            if (!first.places.overlaps(second.places)) continue;
            const double thickness = std::min(at(thickness_.of_cluster, a), at(thickness_.of_cluster, b));
            if (!(furthest(first.motion, second.motion) > step.settings.least_motion * thickness)) continue;
            const Pair pair{std::min(a, b), std::max(a, b)};
            if (body_pair_of(pair) >= 0) list.push_back(pair);
          }
        }
      });
  pair_lists_.join(step.threads, pairs_);
}

void SweptQuery::test_pairs(const Step& step) {
  assign_with_room(tested_, parallel::chunk_count(pairs_.size(), swept_pair_grain), std::size_t{0});
  lists_.fill(step.threads, pairs_.size(), swept_pair_grain,
              [&](std::size_t begin, std::size_t end, std::vector<SweptContact>& list) {
                std::size_t& tested = tested_[begin / swept_pair_grain];
                for (std::size_t i = begin; i < end; ++i) test_pair(step, pairs_[i], list, tested);
              });
  lists_.join(step.threads, contacts_);
  std::sort(contacts_.begin(), contacts_.end(), [](const SweptContact& a, const SweptContact& b) {
    return std::tie(a.kind, a.first, a.second) < std::tie(b.kind, b.first, b.second);
  });
  for (const std::size_t tested : tested_) counts_.tested += tested;
}

/// Tests the points of each cluster against the triangles of the other, and their edges.
void SweptQuery::test_pair(const Step& step, const Pair& pair, std::vector<SweptContact>& found,
                           std::size_t& tested) const {
  const auto& [a, b] = pair;
  const std::array<const Cluster*, 2> clusters{&at(surface_.clusters.clusters, a),
                                               &at(surface_.clusters.clusters, b)};
  const std::array<const Swept*, 2> swept{&at(clusters_, a), &at(clusters_, b)};
  Box places = swept[0]->places;
  places.extend(swept[1]->places);
  const SweptFrame frame(places, middle(swept[0]->motion), middle(swept[1]->motion), step.settings.tolerance);
  std::array<Box, 2> whole;
  for (std::size_t k = 0; k < 2; ++k)
    whole[k] = frame.box_of(step.start, step.end, surface_.clusters.points_of(*clusters[k]));
  if (!whole[0].overlaps(whole[1])) return;

  const auto add = [&](auto& near, Index primitive, const auto& corners, const Box& other) {
    const Box box = frame.box_of(step.start, step.end, corners);
    if (box.overlaps(other)) near.add(primitive, box);
  };
  std::array<Near<most_edges>, 2> points;
  std::array<Near<most_edges>, 2> edges;
  std::array<Near<Cluster::most_primitives>, 2> triangles;
  for (std::size_t k = 0; k < 2; ++k) {
    const Box& other = whole[1 - k];
    for (const Index p : surface_.points[pair[k]]) add(points[k], p, std::array<Index, 1>{p}, other);
    for (const Index e : surface_.edges[pair[k]]) add(edges[k], e, at(bodies_.edges(), e), other);
    for (const Index t : surface_.clusters.primitives_of(*clusters[k]))
      add(triangles[k], t, at(bodies_.triangles(), t), other);
  }
  const auto test = [&](Index point, Index triangle) {
    ++tested;
    test_point(step, point, triangle, found);
  };
  for_each_meeting(points[0], triangles[1], test);
  if (a != b) for_each_meeting(points[1], triangles[0], test);
  const bool one_body = clusters[0]->body == clusters[1]->body;
  for_each_meeting(edges[0], edges[1], [&](Index first, Index second) {
    if (a == b && second <= first) return;
    ++tested;
    const bool swaps = one_body && second < first;
    test_edge(step, swaps ? second : first, swaps ? first : second, found);
  });
}

void SweptQuery::test_point(const Step& step, Index point, Index triangle,
                            std::vector<SweptContact>& found) const {
  const Triangle& corners = at(bodies_.triangles(), triangle);
  const std::array<Index, 1> first{point};
  if (have_common_point(first, corners)) return;
  const auto touch =
      point_meets_triangle(points_of(step.start, step.end, first, corners), step.settings.tolerance);
  if (!touch) return;
  const bool apart_before = touch->direction != Vec3{};
  found.push_back(
      {.kind = SweptKind::point_triangle,
       .first = point,
       .second = triangle,
       .time = touch->time,
       .weights = touch->weights,
       .direction = apart_before ? touch->direction : normalized(area_vector(step.start, corners))});
}

void SweptQuery::test_edge(const Step& step, Index first, Index second,
                           std::vector<SweptContact>& found) const {
  const Edge& a = at(bodies_.edges(), first);
  const Edge& b = at(bodies_.edges(), second);
  if (have_common_point(a, b)) return;
  const auto touch = edge_meets_edge(points_of(step.start, step.end, a, b), step.settings.tolerance);
  if (!touch) return;
  const bool apart_before = touch->direction != Vec3{};
  found.push_back({.kind = SweptKind::edge_edge,
                   .first = first,
                   .second = second,
                   .time = touch->time,
                   .weights = touch->weights,
                   .direction = apart_before ? touch->direction : out_of_edge(step, first, second)});
}

/// The direction orthogonal to both edges at the start of the step, out of the second's body according to the
/// adjacent surfaces.
Vec3 SweptQuery::out_of_edge(const Step& step, Index first, Index second) const {
  const Edge& a = at(bodies_.edges(), first);
  const Edge& b = at(bodies_.edges(), second);
  const Vec3 across = normalized(
      cross(at(step.start, a[1]) - at(step.start, a[0]), at(step.start, b[1]) - at(step.start, b[0])));
  const Vec3 outward =
      outward_of_edge(bodies_, step.start, second) - outward_of_edge(bodies_, step.start, first);
  if (across == Vec3{}) return normalized(outward);
  return dot(across, outward) < 0.0 ? -across : across;
}

}  // namespace palpate

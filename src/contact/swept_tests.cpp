// Tests of the pairs of clusters that SweptQuery has found.
#include <algorithm>
#include <array>
#include <tuple>

#include "contact/swept_frame.hpp"
#include "contact/swept_pair.hpp"
#include "contact/swept_query.hpp"
#include "geometry/triangle.hpp"
#include "mesh/outward.hpp"
#include "room.hpp"

namespace palpate {
namespace {

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
  if (step.filter.are_tied(at(bodies_.body_of_point(), point), first, bodies_.body_of(corners), corners))
    return;
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
  if (step.filter.are_tied(bodies_.body_of(a), a, bodies_.body_of(b), b)) return;
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

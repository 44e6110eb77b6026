#include "contact/edge_query.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 64;

}  // namespace

EdgeQuery::FloatBox::FloatBox(const Box& box) {
  constexpr float rounding = 1.2e-7F;  // of a double that became a float, relative
  const auto down = [](double x) {
    constexpr double most = 1e38;  // what is beyond counts as there
    const auto f = static_cast<float>(std::clamp(x, -most, most));
    return f - (rounding * std::abs(f) + std::numeric_limits<float>::min());
  };
  const auto up = [&](double x) { return -down(-x); };
  lower = {down(box.lower.x), down(box.lower.y), down(box.lower.z)};
  upper = {up(box.upper.x), up(box.upper.y), up(box.upper.z)};
}

void EdgeQuery::TriangleBoxes::put(const FloatBox& box, std::size_t lane) {
  for (std::size_t k = 0; k < 3; ++k) {
    lower[k][lane] = box.lower[k];
    upper[k][lane] = box.upper[k];
  }
}

/// A bit for each lane whose box meets another; written so that compilers make vectors of it.
std::uint32_t EdgeQuery::TriangleBoxes::meeting(const FloatBox& box) const {
  std::array<std::int32_t, Cluster::most_primitives> bits{};
  for (std::size_t i = 0; i < bits.size(); ++i) {
    const int meets =
        static_cast<int>(lower[0][i] <= box.upper[0]) & static_cast<int>(lower[1][i] <= box.upper[1]) &
        static_cast<int>(lower[2][i] <= box.upper[2]) & static_cast<int>(box.lower[0] <= upper[0][i]) &
        static_cast<int>(box.lower[1] <= upper[1][i]) & static_cast<int>(box.lower[2] <= upper[2][i]);
    bits[i] = meets << i;
  }
  std::int32_t all = 0;
  for (const std::int32_t bit : bits) all |= bit;
  return static_cast<std::uint32_t>(all);
}

struct EdgeQuery::Frame {
  const parallel::Threads& threads;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const PairFilter& may_touch;
  const ContactTable& contacts;
};

EdgeQuery::EdgeQuery(const Bodies& bodies, const SurfaceSides& sides)
    : clusters_(make_triangle_clusters(bodies)),
      boxes_(clusters_.clusters.size()),
      body_boxes_(bodies.bodies().size()),
      triangle_boxes_(clusters_.clusters.size()) {
  std::vector<std::uint8_t> owned(bodies.edges().size(), 0);
  for (const Cluster& cluster : clusters_.clusters) {
    for (const Index t : clusters_.primitives_of(cluster)) {
      for (const Index edge : at(sides.edges, t)) {
        if (std::exchange(at(owned, edge), 1) == 0) edges_.values.push_back(edge);
      }
    }
    edges_.begin.push_back(static_cast<Index>(edges_.values.size()));
  }
  edge_boxes_.resize(edges_.values.size());
}

void EdgeQuery::find_boxes(const Frame& frame) {
  parallel::for_each(frame.threads, boxes_.size(), grain, [&](std::size_t c) {
    boxes_[c] = box_of(frame.positions, clusters_.points_of(clusters_.clusters[c]));
  });
  std::ranges::fill(body_boxes_, Box{});
  for (std::size_t c = 0; c < boxes_.size(); ++c)
    at(body_boxes_, clusters_.clusters[c].body).extend(boxes_[c]);
}

/// Pairs of bodies whose boxes meet and that may touch, as rows.
void EdgeQuery::pair_bodies(const Frame& frame) {
  body_order_.clear();
  make_room(body_order_, body_boxes_.size());
  for (std::size_t b = 0; b < body_boxes_.size(); ++b)
    body_order_.emplace_back(body_boxes_[b].lower.x, static_cast<Index>(b));
  std::ranges::sort(body_order_);
  body_pairs_.clear();
  for (std::size_t i = 0; i < body_order_.size(); ++i) {
    const Index a = body_order_[i].second;
    const Box& box = at(body_boxes_, a);
    for (std::size_t j = i + 1; j < body_order_.size() && body_order_[j].first <= box.upper.x; ++j) {
      const Index b = body_order_[j].second;
      if (!box.overlaps(at(body_boxes_, b)) || !frame.may_touch.bodies(a, b)) continue;
      make_room(body_pairs_, body_pairs_.size() + 2);
      body_pairs_.emplace_back(a, b);
      body_pairs_.emplace_back(b, a);
    }
  }
  std::ranges::sort(body_pairs_);
}

/// Clusters whose boxes meet that of a body that theirs may touch.
void EdgeQuery::choose_clusters(const Frame& frame) {
  active_.clear();
  make_room(active_, boxes_.size());
  for (std::size_t c = 0; c < boxes_.size(); ++c) {
    const auto of_body = std::ranges::equal_range(body_pairs_, clusters_.clusters[c].body, {}, &Pair::first);
    if (std::ranges::any_of(of_body,
                            [&](const Pair& p) { return boxes_[c].overlaps(at(body_boxes_, p.second)); }))
      active_.emplace_back(boxes_[c].lower.x, static_cast<Index>(c));
  }
  std::ranges::sort(active_);
  parallel::for_each(frame.threads, active_.size(), grain, [&](std::size_t i) {
    const Index c = active_[i].second;
    const Cluster& cluster = at(clusters_.clusters, c);
    TriangleBoxes& boxes = at(triangle_boxes_, c);
    const std::span<const Index> triangles = clusters_.primitives_of(cluster);
    for (std::size_t lane = 0; lane < Cluster::most_primitives; ++lane) {
      const Box box = lane < triangles.size()
                          ? box_of(frame.positions, at(frame.bodies.triangles(), triangles[lane]))
                          : Box{};
      boxes.put(FloatBox(box), lane);
    }
    for (Index k = at(edges_.begin, c); k < at(edges_.begin, c + 1); ++k)
      at(edge_boxes_, k) = FloatBox(box_of(frame.positions, at(frame.bodies.edges(), at(edges_.values, k))));
  });
}

void EdgeQuery::pair_clusters(const Frame& frame) {
  pair_lists_.fill(
      frame.threads, active_.size(), grain, [&](std::size_t begin, std::size_t end, std::vector<Pair>& list) {
        for (std::size_t i = begin; i < end; ++i) {
          const Index a = active_[i].second;
          const Box& box = at(boxes_, a);
          const Index body = at(clusters_.clusters, a).body;
          for (std::size_t j = i + 1; j < active_.size() && active_[j].first <= box.upper.x; ++j) {
            const Index b = active_[j].second;
            const Index other = at(clusters_.clusters, b).body;
            if (other != body && box.overlaps(at(boxes_, b)) && frame.may_touch.bodies(body, other))
              list.emplace_back(a, b);
          }
        }
      });
  pair_lists_.join(pairs_);
}

void EdgeQuery::test(const Frame& frame, Index cluster_of_edges, Index cluster_of_triangles,
                     std::vector<EdgeHit>& found) const {
  const Cluster& cluster = at(clusters_.clusters, cluster_of_triangles);
  const Box& a = at(boxes_, cluster_of_edges);
  const Box& b = at(boxes_, cluster_of_triangles);
  // What meets, meets where both clusters are.
  const Box both{
      {std::max(a.lower.x, b.lower.x), std::max(a.lower.y, b.lower.y), std::max(a.lower.z, b.lower.z)},
      {std::min(a.upper.x, b.upper.x), std::min(a.upper.y, b.upper.y), std::min(a.upper.z, b.upper.z)}};
  const FloatBox around(both);
  const TriangleBoxes& boxes = at(triangle_boxes_, cluster_of_triangles);
  const std::uint32_t near = boxes.meeting(around) & ((1U << cluster.size) - 1U);
  if (near == 0) return;
  const std::span<const Vec3> x = frame.positions;
  const std::span<const Index> triangles = clusters_.primitives_of(cluster);
  for (Index e = at(edges_.begin, cluster_of_edges); e < at(edges_.begin, cluster_of_edges + 1); ++e) {
    const FloatBox& box = at(edge_boxes_, e);
    const auto apart = [&](std::size_t k) {
      return box.upper[k] < around.lower[k] || around.upper[k] < box.lower[k];
    };
    if (apart(0) || apart(1) || apart(2)) continue;
    const Edge& edge = at(frame.bodies.edges(), at(edges_.values, e));
    for (std::uint32_t left = near & boxes.meeting(box); left != 0; left &= left - 1) {
      const Index triangle = triangles[static_cast<std::size_t>(std::countr_zero(left))];
      const Triangle& t = at(frame.bodies.triangles(), triangle);
      if (!segment_meets_triangle(at(x, edge[0]), at(x, edge[1]), at(x, t[0]), at(x, t[1]), at(x, t[2])))
        continue;
      if (frame.contacts.find(edge[0], cluster.body) >= 0 || frame.contacts.find(edge[1], cluster.body) >= 0)
        break;
      found.push_back({at(edges_.values, e), triangle});
    }
  }
}

void EdgeQuery::find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const PairFilter& may_touch, const ContactTable& contacts) {
  const Frame frame{threads, bodies, positions, may_touch, contacts};
  find_boxes(frame);
  pair_bodies(frame);
  choose_clusters(frame);
  pair_clusters(frame);
  hit_lists_.fill(threads, pairs_.size(), grain,
                  [&](std::size_t begin, std::size_t end, std::vector<EdgeHit>& found) {
                    for (std::size_t i = begin; i < end; ++i) {
                      test(frame, pairs_[i].first, pairs_[i].second, found);
                      test(frame, pairs_[i].second, pairs_[i].first, found);
                    }
                  });
  hit_lists_.join(found_);
  std::ranges::sort(found_, {}, [](const EdgeHit& hit) { return std::pair(hit.edge, hit.triangle); });
}

}  // namespace palpate

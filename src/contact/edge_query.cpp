#include "contact/edge_query.hpp"

#include <algorithm>
#include <array>
#include <tuple>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 64;

}  // namespace

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
      triangle_boxes_(bodies.triangles().size()) {
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
    for (Index k = cluster.first; k < cluster.first + cluster.size; ++k)
      at(triangle_boxes_, k) =
          box_of(frame.positions, at(frame.bodies.triangles(), at(clusters_.primitives, k)));
    for (Index k = at(edges_.begin, c); k < at(edges_.begin, c + 1); ++k)
      at(edge_boxes_, k) = box_of(frame.positions, at(frame.bodies.edges(), at(edges_.values, k)));
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
  std::array<Index, Cluster::most_primitives> near{};
  std::size_t count = 0;
  for (Index k = cluster.first; k < cluster.first + cluster.size; ++k)
    if (at(triangle_boxes_, k).overlaps(both)) near[count++] = k;
  if (count == 0) return;
  const std::span<const Vec3> x = frame.positions;
  for (Index e = at(edges_.begin, cluster_of_edges); e < at(edges_.begin, cluster_of_edges + 1); ++e) {
    const Box& box = at(edge_boxes_, e);
    if (!box.overlaps(both)) continue;
    const Edge& edge = at(frame.bodies.edges(), at(edges_.values, e));
    for (const Index k : std::span(near).first(count)) {
      if (!box.overlaps(at(triangle_boxes_, k))) continue;
      const Triangle& t = at(frame.bodies.triangles(), at(clusters_.primitives, k));
      if (!segment_meets_triangle(at(x, edge[0]), at(x, edge[1]), at(x, t[0]), at(x, t[1]), at(x, t[2])))
        continue;
      if (frame.contacts.find(edge[0], cluster.body) >= 0 || frame.contacts.find(edge[1], cluster.body) >= 0)
        break;
      found.push_back({at(edges_.values, e), at(clusters_.primitives, k)});
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

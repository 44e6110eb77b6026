#include "contact/edge_search.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 64;

}  // namespace

EdgeSearch::FloatBox::FloatBox(const Box& box) {
  constexpr float rounding = 1.2e-7F;  // relative rounding error of a double converted to float
  const auto down = [](double x) {
    constexpr double most = 1e38;  // larger values are clamped to it
    const auto f = static_cast<float>(std::clamp(x, -most, most));
    return f - (rounding * std::abs(f) + std::numeric_limits<float>::min());
  };
  const auto up = [&](double x) { return -down(-x); };
  lower = {down(box.lower.x), down(box.lower.y), down(box.lower.z)};
  upper = {up(box.upper.x), up(box.upper.y), up(box.upper.z)};
}

void EdgeSearch::TriangleBoxes::put(const FloatBox& box, std::size_t lane) {
  for (std::size_t k = 0; k < 3; ++k) {
    lower[k][lane] = box.lower[k];
    upper[k][lane] = box.upper[k];
  }
}

/// A bit for each lane whose box meets the given one; written so that compilers vectorise it.
std::uint32_t EdgeSearch::TriangleBoxes::meeting(const FloatBox& box) const {
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

struct EdgeSearch::Frame {
  const parallel::Threads& threads;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  std::span<const Box> boxes;
  std::span<const double> grown;
};

EdgeSearch::EdgeSearch(const Bodies& bodies)
    : surface_(bodies),
      boxes_(surface_.clusters.clusters.size()),
      body_boxes_(bodies.bodies().size()),
      triangle_boxes_(boxes_.size()),
      edge_boxes_(surface_.edges.values.size()) {}

bool EdgeSearch::is_pair(Index body, Index other) const {
  return std::ranges::binary_search(symmetric_pairs_, Pair(body, other));
}

/// Computes the boxes of the bodies in a pair.
void EdgeSearch::find_boxes(const Frame& frame) {
  Index last = -1;
  for (const Pair& pair : symmetric_pairs_) {
    const Index body = pair.first;
    if (std::exchange(last, body) == body) continue;
    const Range range = at(surface_.of_body, body);
    Box& box = at(body_boxes_, body) = {};
    for (Index c = range.begin; c < range.end; ++c)
      box.extend(at(boxes_, c) = grown(at(frame.boxes, c), at(frame.grown, body)));
  }
}

/// Finds clusters whose boxes meet that of the other body of a pair.
void EdgeSearch::choose_clusters(const Frame& frame) {
  active_.clear();
  make_room(active_, boxes_.size());
  for (auto of_body = symmetric_pairs_.begin(); of_body != symmetric_pairs_.end();) {
    const Index body = of_body->first;
    const auto end = std::ranges::upper_bound(of_body, symmetric_pairs_.end(), body, {}, &Pair::first);
    const Range range = at(surface_.of_body, body);
    for (Index c = range.begin; c < range.end; ++c) {
      const Box& box = at(boxes_, c);
      if (std::any_of(of_body, end, [&](const Pair& p) { return box.overlaps(at(body_boxes_, p.second)); }))
        active_.emplace_back(box.lower.x, c);
    }
    of_body = end;
  }
  std::ranges::sort(active_);
  parallel::for_each(frame.threads, active_.size(), grain, [&](std::size_t i) {
    const Index c = active_[i].second;
    const Cluster& cluster = at(surface_.clusters.clusters, c);
    const double by = at(frame.grown, cluster.body);
    const auto box_around = [&](const auto& corners) {
      return FloatBox(grown(box_of(frame.positions, corners), by));
    };
    TriangleBoxes& boxes = at(triangle_boxes_, c);
    const std::span<const Index> triangles = surface_.clusters.primitives_of(cluster);
    for (std::size_t lane = 0; lane < Cluster::most_primitives; ++lane) {
      boxes.put(lane < triangles.size() ? box_around(at(frame.bodies.triangles(), triangles[lane]))
                                        : FloatBox(Box{}),
                lane);
    }
    for (Index k = at(surface_.edges.begin, c); k < at(surface_.edges.begin, c + 1); ++k)
      at(edge_boxes_, k) = box_around(at(frame.bodies.edges(), at(surface_.edges.values, k)));
  });
}

void EdgeSearch::pair_clusters(const Frame& frame) {
  pair_lists_.fill(
      frame.threads, active_.size(), grain, [&](std::size_t begin, std::size_t end, std::vector<Pair>& list) {
        for (std::size_t i = begin; i < end; ++i) {
          const Index a = active_[i].second;
          const Box& box = at(boxes_, a);
          const Index body = at(surface_.clusters.clusters, a).body;
          for (std::size_t j = i + 1; j < active_.size() && active_[j].first <= box.upper.x; ++j) {
            const Index b = active_[j].second;
            const Index other = at(surface_.clusters.clusters, b).body;
            if (other != body && box.overlaps(at(boxes_, b)) && is_pair(body, other)) list.emplace_back(a, b);
          }
        }
      });
  pair_lists_.join(pairs_);
}

void EdgeSearch::list(Index cluster_of_edges, Index cluster_of_triangles,
                      std::vector<EdgeTriangle>& found) const {
  const Cluster& cluster = at(surface_.clusters.clusters, cluster_of_triangles);
  const Box& a = at(boxes_, cluster_of_edges);
  const Box& b = at(boxes_, cluster_of_triangles);
  // Edges and triangles can meet only in the common part of both clusters' boxes.
  const Box both{
      {std::max(a.lower.x, b.lower.x), std::max(a.lower.y, b.lower.y), std::max(a.lower.z, b.lower.z)},
      {std::min(a.upper.x, b.upper.x), std::min(a.upper.y, b.upper.y), std::min(a.upper.z, b.upper.z)}};
  const FloatBox around(both);
  const TriangleBoxes& boxes = at(triangle_boxes_, cluster_of_triangles);
  const std::uint32_t near = boxes.meeting(around) & ((1U << cluster.size) - 1U);
  if (near == 0) return;
  const std::span<const Index> triangles = surface_.clusters.primitives_of(cluster);
  for (Index e = at(surface_.edges.begin, cluster_of_edges);
       e < at(surface_.edges.begin, cluster_of_edges + 1); ++e) {
    const FloatBox& box = at(edge_boxes_, e);
    const auto apart = [&](std::size_t k) {
      return box.upper[k] < around.lower[k] || around.upper[k] < box.lower[k];
    };
    if (apart(0) || apart(1) || apart(2)) continue;
    for (std::uint32_t left = near & boxes.meeting(box); left != 0; left &= left - 1) {
      found.push_back(
          {at(surface_.edges.values, e), triangles[static_cast<std::size_t>(std::countr_zero(left))]});
    }
  }
}

void EdgeSearch::find(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                      std::span<const Box> boxes, std::span<const Pair> pairs,
                      std::span<const double> grown) {
  symmetric_pairs_.clear();
  make_room(symmetric_pairs_, 2 * pairs.size());
  for (const auto& [a, b] : pairs) {
    symmetric_pairs_.emplace_back(a, b);
    symmetric_pairs_.emplace_back(b, a);
  }
  std::ranges::sort(symmetric_pairs_);
  const Frame frame{threads, bodies, positions, boxes, grown};
  find_boxes(frame);
  choose_clusters(frame);
  pair_clusters(frame);
  resize_with_room(groups_, pairs_.size());
  lists_.fill(threads, pairs_.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<EdgeTriangle>& found) {
                for (std::size_t i = begin; i < end; ++i) {
                  const std::size_t before = found.size();
                  list(pairs_[i].first, pairs_[i].second, found);
                  list(pairs_[i].second, pairs_[i].first, found);
                  groups_[i] = {pairs_[i], found.size() - before};
                }
              });
  lists_.join(found_);
  // The clusters of a chunk vary, so memory is reserved for all chunks; then only the first steps allocate.
  for (std::size_t i = 0; i < groups_.size(); i += grain) {
    const std::span<const Group> chunk = std::span(groups_).subspan(i, std::min(grain, groups_.size() - i));
    std::size_t size = 0;
    for (const Group& group : chunk) size += group.size;
    if (size > most_of_chunk_) most_of_chunk_ = size + size / 2;
  }
  const std::size_t chunks = parallel::chunk_count(pairs_.size(), grain);
  lists_.make_room_in_all(chunks + chunks / 4 + 1, most_of_chunk_);
}

}  // namespace palpate

#include "contact/triangle_tree.hpp"

#include <numeric>

#include "room.hpp"

namespace palpate {

using simd::BoxGroup;
using simd::LeafTriangles;

TriangleTree::TriangleTree(const Bodies& bodies, const Clusters& clusters)
    : triangles_(clusters.clusters.size()),
      extents_(clusters.clusters.size()),
      mean_extent_(bodies.bodies().size(), 1) {
  Level leaves;
  leaves.of_body.resize(bodies.bodies().size());
  for (std::size_t c = 0; c < clusters.clusters.size(); ++c) {
    const Cluster& cluster = clusters.clusters[c];
    const std::span<const Index> own = clusters.primitives_of(cluster);
    for (std::size_t place = 0; place < BoxGroup::most; ++place) {
      const Index triangle = own[place < own.size() ? place : 0];
      for (std::size_t k = 0; k < 3; ++k)
        triangles_[c].corner[k][place] = simd::place_of_point(at(bodies.triangles(), triangle)[k]);
      triangles_[c].triangle[place] = place < own.size() ? triangle : -1;
    }
    const auto number = static_cast<Index>(c);
    leaves.first_child.push_back(LeafTriangles::stride * number);
    Range& range = at(leaves.of_body, cluster.body);
    if (range.size() == 0) range.begin = number;
    range.end = number + 1;
  }
  leaves.nodes.resize(clusters.clusters.size());
  levels_.push_back(std::move(leaves));
  while (add_level()) {
  }
  for (std::size_t b = 0; b < bodies.bodies().size(); ++b) {
    std::size_t level = 0;
    while (levels_[level].of_body[b].size() > most_at_top) ++level;
    const Range range = levels_[level].of_body[b];
    Top top{level, static_cast<std::size_t>(range.size()), {}};
    std::iota(top.nodes.begin(), top.nodes.end(), range.begin);
    top_.push_back(top);
  }
}

/// Adds the parents of the highest level; returns whether a body has more than a few of them.
bool TriangleTree::add_level() {
  constexpr auto most = static_cast<Index>(BoxGroup::most);
  Level level;
  bool is_large = false;
  for (const Range& children : levels_.back().of_body) {
    const auto begin = static_cast<Index>(level.first_child.size());
    for (Index child = children.begin; child < children.end; child += most)
      level.first_child.push_back(child);
    level.of_body.push_back({begin, static_cast<Index>(level.first_child.size())});
    is_large = is_large || level.of_body.back().size() > most_at_top;
  }
  level.nodes.resize(level.first_child.size());
  levels_.push_back(std::move(level));
  return is_large;
}

void TriangleTree::fit(const parallel::Threads& threads, std::span<const simd::FixedPoint> points,
                       std::span<const std::uint8_t> bodies) {
  const simd::CrossingKernels kernels = simd::crossing_kernels();
  for (std::size_t level = 1; level < levels_.size(); ++level) {
    Level& parents = levels_[level];
    Level& children = levels_[level - 1];
    active_.clear();
    make_room(active_, parents.nodes.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      const Range range = bodies[b] != 0 ? parents.of_body[b] : Range{};
      for (Index node = range.begin; node < range.end; ++node)
        active_.push_back({node, children_of(level, b, node)});
    }
    parallel::for_each(threads, active_.size(), 4, [&](std::size_t i) {
      const auto [node, range] = active_[i];
      const auto begin = static_cast<std::size_t>(range.begin);
      const auto size = static_cast<std::size_t>(range.size());
      if (level > 1) {
        kernels.fit_parent(std::span(children.nodes).subspan(begin, size), at(parents.nodes, node));
      } else {
        kernels.fit_leaves(points.data(), std::span(triangles_).subspan(begin, size), &children.nodes[begin],
                           &extents_[begin], at(parents.nodes, node));
      }
    });
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Range& leaves = levels_.front().of_body[b];
    if (bodies[b] == 0 || leaves.size() == 0) continue;
    std::int64_t sum = 0;
    for (Index leaf = leaves.begin; leaf < leaves.end; ++leaf) sum += at(extents_, leaf);
    mean_extent_[b] = static_cast<std::int32_t>(std::max<std::int64_t>(1, sum / leaves.size()));
  }
}

Range TriangleTree::children_of(std::size_t level, std::size_t body, Index node) const {
  const Index begin = at(levels_[level].first_child, node);
  return {begin, std::min(begin + static_cast<Index>(BoxGroup::most), levels_[level - 1].of_body[body].end)};
}

std::size_t TriangleTree::bytes() const {
  std::size_t sum = triangles_.size() * sizeof(LeafTriangles);
  for (const Level& level : levels_) sum += level.nodes.size() * sizeof(BoxGroup);
  return sum;
}

}  // namespace palpate

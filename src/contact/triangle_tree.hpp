#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "mesh/clusters.hpp"
#include "parallel/parallel.hpp"
#include "simd/crossing_query.hpp"

namespace palpate {

/// A tree of boxes over the surface triangles of each body. Its leaves are clusters of triangles, its other
/// nodes have up to 16 children that follow each other. Which triangle is where never changes; the boxes
/// follow the fixed positions.
class TriangleTree {
 public:
  TriangleTree(const Bodies& bodies, const Clusters& clusters);

  /// Computes the boxes of some bodies. O(their triangles), parallel.
  /// \param bodies  (n_bodies) nonzero for these
  void fit(const parallel::Threads& threads, std::span<const simd::FixedPoint> points,
           std::span<const std::uint8_t> bodies);

  /// Calls visit(leaves) for the leaves of a body that meet a box, in parts of at most `most_nodes`. Leaf c
  /// is cluster c. Those of a body with few leaves may not meet it.
  template <class Visit>
  void for_each_leaf(const simd::CrossingKernels& kernels, Index body, const simd::FixedBox& box,
                     Visit&& visit) const {
    const Top& top = at(top_, body);
    descend(kernels, top.level, std::span(top.nodes).first(top.size), box, visit);
  }

  static constexpr std::size_t most_nodes = 16;
  /// Room for the children of that many nodes.
  using Children =
      std::array<std::int32_t, most_nodes * simd::BoxGroup::most + simd::CrossingKernels::padding>;
  /// Lists the entries of some leaves, at most `most_nodes`, whose boxes meet a box.
  [[nodiscard]] std::span<std::int32_t> list_entries(const simd::CrossingKernels& kernels,
                                                     std::span<const std::int32_t> leaves,
                                                     const simd::FixedBox& box, Children& entries) const {
    return {entries.data(), list(kernels, levels_.front(), leaves, box, entries)};
  }

  /// (n_leaves) entry e is triangles()->triangle.data()[e].
  [[nodiscard]] const simd::LeafTriangles* triangles() const { return triangles_.data(); }
  [[nodiscard]] static std::int32_t leaf_of(std::int32_t entry) {
    return entry / simd::LeafTriangles::stride;
  }
  /// The longest side of the box of a triangle of a leaf.
  [[nodiscard]] std::int32_t extent(std::int32_t leaf) const { return at(extents_, leaf); }
  /// The mean of these over the leaves of a body; at least 1.
  [[nodiscard]] std::int32_t mean_extent(Index body) const { return at(mean_extent_, body); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  struct Level {
    std::vector<simd::BoxGroup> nodes;
    std::vector<std::int32_t> first_child;
    std::vector<Range> of_body;  ///< (n_bodies) nodes
  };
  /// Where searches begin: at the lowest level where a body has at most `most_at_top` nodes.
  struct Top {
    std::size_t level;
    std::size_t size;
    std::array<std::int32_t, 4> nodes;
  };
  /// A node to compute.
  struct Active {
    Index node;
    Range children;
  };
  static constexpr Index most_at_top = 4;

  bool add_level();
  [[nodiscard]] Range children_of(std::size_t level, std::size_t body, Index node) const;
  [[nodiscard]] static std::size_t list(const simd::CrossingKernels& kernels, const Level& level,
                                        std::span<const std::int32_t> nodes, const simd::FixedBox& box,
                                        Children& children) {
    return kernels.list_children(level.nodes.data(), level.first_child.data(), nodes, box, children.data());
  }
  template <class Visit>
  void descend(const simd::CrossingKernels& kernels, std::size_t level, std::span<const std::int32_t> nodes,
               const simd::FixedBox& box, Visit&& visit) const {
    while (!nodes.empty()) {
      const auto part = nodes.first(std::min(nodes.size(), most_nodes));
      nodes = nodes.subspan(part.size());
      if (level == 0) {
        visit(part);
        continue;
      }
      Children children;
      const std::size_t size = list(kernels, levels_[level], part, box, children);
      descend(kernels, level - 1, std::span<const std::int32_t>(children.data(), size), box, visit);
    }
  }

  std::vector<simd::LeafTriangles> triangles_;  ///< (n_clusters)
  std::vector<std::int32_t> extents_;           ///< (n_clusters)
  std::vector<std::int32_t> mean_extent_;       ///< (n_bodies)
  std::vector<Level> levels_;                   ///< from the leaves up
  std::vector<Top> top_;                        ///< (n_bodies)
  std::vector<Active> active_;                  ///< scratch
};

}  // namespace palpate

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::view {

/// The visible part of the bodies: the surface triangles, and their points, renumbered as vertices in the
/// order of points. So the vertices of a body are a range, like its triangles.
class Surface {
 public:
  explicit Surface(const Bodies& bodies);

  [[nodiscard]] Index vertex_count() const { return static_cast<Index>(points_.size()); }
  [[nodiscard]] std::span<const Index> points() const { return points_; }  ///< (n_vertices) point of a vertex
  /// The vertex of a point; -1 for an inner point.
  [[nodiscard]] Index vertex_of(Index point) const { return vertices_[static_cast<std::size_t>(point)]; }
  /// The points that are no vertices, in their order.
  [[nodiscard]] std::span<const Index> inner_points() const { return inner_points_; }
  /// The number of a point where vertices come first, then inner points.
  [[nodiscard]] Index corner_of(Index point) const { return corners_[static_cast<std::size_t>(point)]; }
  [[nodiscard]] std::span<const Triangle> triangles() const { return triangles_; }  ///< corners are vertices
  [[nodiscard]] std::span<const Range> body_vertices() const { return body_vertices_; }  ///< (n_bodies)

 private:
  std::vector<Index> points_;
  std::vector<Index> vertices_;
  std::vector<Index> inner_points_;
  std::vector<Index> corners_;
  std::vector<Triangle> triangles_;
  std::vector<Range> body_vertices_;
};

}  // namespace palpate::view

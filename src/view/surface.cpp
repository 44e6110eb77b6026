#include "view/surface.hpp"

#include "geometry/vector.hpp"

namespace palpate::view {

Surface::Surface(const Bodies& bodies) : vertices_(bodies.points_rest().size(), -1) {
  for (const Triangle& triangle : bodies.triangles()) {
    for (const Index point : triangle) at(vertices_, point) = 0;
  }
  for (const Body& body : bodies.bodies()) {
    const auto begin = static_cast<Index>(points_.size());
    for (Index point = body.points.begin; point < body.points.end; ++point) {
      if (at(vertices_, point) < 0) {
        inner_points_.push_back(point);
        continue;
      }
      at(vertices_, point) = static_cast<Index>(points_.size());
      points_.push_back(point);
    }
    body_vertices_.push_back({begin, static_cast<Index>(points_.size())});
  }
  for (const auto& [a, b, c] : bodies.triangles()) {
    triangles_.push_back({vertex_of(a), vertex_of(b), vertex_of(c)});
  }
  corners_ = vertices_;
  Index next = vertex_count();
  for (const Index point : inner_points_) at(corners_, point) = next++;
}

}  // namespace palpate::view

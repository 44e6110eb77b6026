#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/triangle.hpp"
#include "geometry/vector.hpp"

namespace palpate::test {

/// Nearest point of a triangle: the foot on its plane, or the nearest point of a side.
inline Vec3 nearest_of_triangle(const std::array<Vec3, 3>& t, const Vec3& p) {
  const Vec3 n = normalized(area_vector(t));
  const Vec3 foot = p - dot(n, p - t[0]) * n;
  bool is_in = true;
  Vec3 nearest = t[0];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 a = t[i];
    const Vec3 side = t[(i + 1) % 3] - a;
    is_in = is_in && dot(cross(side, foot - a), n) >= 0.0;
    const Vec3 x = a + std::clamp(dot(p - a, side) / squared_length(side), 0.0, 1.0) * side;
    if (squared_length(x - p) < squared_length(nearest - p)) nearest = x;
  }
  return is_in ? foot : nearest;
}

/// A segment from p (t = 0) to q (t = 1) crosses a triangle.
struct SegmentCrossing {
  double t = 0.0;
  Index triangle = -1;
  bool leaves = false;  ///< along the triangle's normal
};

/// The surface triangles of a body, one by one.
class AllTriangles {
 public:
  AllTriangles(const Bodies& bodies, std::span<const Vec3> positions, Index body)
      : bodies_(bodies), x_(positions) {
    for (Index t = 0; t < static_cast<Index>(bodies.triangles().size()); ++t)
      if (bodies.body_of(at(bodies.triangles(), t)) == body) triangles_.push_back(t);
  }
  [[nodiscard]] std::span<const Index> all() const { return triangles_; }
  [[nodiscard]] std::array<Vec3, 3> corners(Index triangle) const {
    return corners_of(x_, at(bodies_.triangles(), triangle));
  }
  /// Crossings of a segment in general position, by the signs of volumes.
  [[nodiscard]] std::vector<SegmentCrossing> crossings(const Vec3& p, const Vec3& q) const {
    const auto volume = [](const Vec3& u, const Vec3& v, const Vec3& w) { return dot(cross(u, v), w); };
    std::vector<SegmentCrossing> found;
    for (const Index t : triangles_) {
      const auto& [a, b, c] = corners(t);
      const double of_p = volume(b - a, c - a, p - a);
      const double of_q = volume(b - a, c - a, q - a);
      if ((of_p > 0.0) == (of_q > 0.0)) continue;
      const bool ab = volume(a - p, b - p, q - p) > 0.0;
      const bool bc = volume(b - p, c - p, q - p) > 0.0;
      const bool ca = volume(c - p, a - p, q - p) > 0.0;
      if (ab == bc && bc == ca) found.push_back({of_p / (of_p - of_q), t, of_q > 0.0});
    }
    return found;
  }
  /// The nearest point of the surface.
  [[nodiscard]] Vec3 nearest(const Vec3& p) const {
    Vec3 nearest = nearest_of_triangle(corners(triangles_.front()), p);
    for (const Index t : triangles_) {
      const Vec3 x = nearest_of_triangle(corners(t), p);
      if (squared_length(x - p) < squared_length(nearest - p)) nearest = x;
    }
    return nearest;
  }
  [[nodiscard]] double distance(const Vec3& p) const { return length(nearest(p) - p); }

 private:
  const Bodies& bodies_;
  std::span<const Vec3> x_;
  std::vector<Index> triangles_;
};

}  // namespace palpate::test

#include "contact/silhouette.hpp"

#include <algorithm>
#include <array>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

constexpr std::size_t most_triangles = 256;
/// Relative to the length of an edge: a line nearer to it than this leaves across it, regardless of rounding.
constexpr double at_side = 1e-6;
/// Sine of the angle between the line and a triangle that is seen exactly edge-on.
constexpr double edge_on = 1e-9;

bool has_end(const Triangle& triangle, const Edge& edge) {
  return std::ranges::any_of(triangle, [&](Index p) { return p == edge[0] || p == edge[1]; });
}

}  // namespace

bool SilhouetteSearch::has_reached(Index triangle) const {
  return std::ranges::find(reached_, triangle) != reached_.end();
}

/// Sets the sides of a triangle.
void SilhouetteSearch::find_sides(const Bodies& bodies, std::span<const Vec3> positions, const EdgeLine& line,
                                  Index triangle) {
  const Triangle& corners = at(bodies.triangles(), triangle);
  const std::array<Index, 3>& neighbors = at(bodies.triangle_neighbors(), triangle);
  for (std::size_t i = 0; i < 3; ++i) {
    sides_.from[i] = corners[(i + 1) % 3];
    sides_.to[i] = corners[(i + 2) % 3];
    const Triangle& beyond = at(bodies.triangles(), std::max(0, neighbors[i]));
    for (std::size_t k = 0; k < 3; ++k) sides_.neighbor[k][i] = beyond[k];
  }
  simd::find_sides(positions.data(), line.x, line.d, sides_);
}

/// Vector out of the triangle over a side, across the line.
Vec3 SilhouetteSearch::outward_over(std::span<const Vec3> positions, const EdgeLine& line, std::size_t side,
                                    Index third) const {
  const double l2 = sides_.length2[side];
  const Vec3 a = across(at(positions, sides_.from[side]) - line.x, line.d);
  const Vec3 ab = across(at(positions, sides_.to[side]) - line.x, line.d) - a;
  const Vec3 inward = across(at(positions, third) - line.x, line.d) - a;
  return l2 > 0.0 ? (dot(inward, ab) / l2) * ab - inward : -inward;
}

/// \param third   corner of the triangle that is opposite to the side
/// \param beyond  the triangle beyond
void SilhouetteSearch::consider_outline(std::span<const Vec3> positions, const EdgeLine& line,
                                        std::size_t side, Index third, Index beyond, Best& best) const {
  const double distance = sides_.distance[side];
  // A line that is nearly at the side leaves across it.
  const bool is_apart = distance * distance > at_side * at_side * sides_.length2[side];
  const Vec3 direction = is_apart ? (1.0 / distance) * Vec3{sides_.x[side], sides_.y[side], sides_.z[side]}
                                  : normalized(outward_over(positions, line, side, third));
  if (distance < best.nearest) {
    best.nearest = distance;
    best.exit.has_left = is_apart && !line.is_own && line.allowance(-direction) == 0.0 &&
                         dot(direction, outward_over(positions, line, side, third)) < 0.0;
  }
  const double bound = distance + line.allowance(direction);
  if (bound >= best.bound) return;
  best.exit = {distance, direction, beyond, best.exit.has_left};
  best.bound = bound;
}

void SilhouetteSearch::consider(const Bodies& bodies, std::span<const Vec3> positions, const EdgeLine& line,
                                const Reached& here, Best& best) {
  const Triangle& corners = at(bodies.triangles(), here.triangle);
  const std::array<Index, 3>& neighbors = at(bodies.triangle_neighbors(), here.triangle);
  find_sides(bodies, positions, line, here.triangle);
  for (std::size_t i = 0; i < 3; ++i) {
    const Index other = neighbors[i];
    const double distance = sides_.distance[i];
    if ((other >= 0 && other == here.from) || distance >= best.bound) continue;
    // A line of the same body: an exit to the surface at the edge itself is none.
    if (line.is_own && other >= 0 && has_end(at(bodies.triangles(), other), line.ends)) continue;
    // A triangle that is seen edge-on, as in flush faces, has no inside. The outline ends before it.
    const double facing = ahead_ ? sides_.facing[i] : -sides_.facing[i];
    const bool goes_on = other >= 0 && facing > edge_on;
    if (!goes_on) {
      consider_outline(positions, line, i, corners[i], other, best);
    } else if (!has_reached(other)) {
      reached_.push_back(other);
      heap_.push_back({distance, other, here.triangle});
      std::ranges::push_heap(heap_, std::greater{}, &Reached::distance);
    }
  }
}

LineExit SilhouetteSearch::nearest(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                   const EdgeLine& line, double limit) {
  ahead_ = dot(area_vector(positions, at(bodies.triangles(), triangle)), line.d) > 0.0;
  Best best{{}, limit};
  if (limit <= 0.0) return best.exit;
  heap_.clear();
  reached_.clear();
  reached_.push_back(triangle);
  consider(bodies, positions, line, {0.0, triangle, -1}, best);
  while (!heap_.empty() && reached_.size() < most_triangles) {
    std::ranges::pop_heap(heap_, std::greater{}, &Reached::distance);
    const Reached here = heap_.back();
    heap_.pop_back();
    if (here.distance >= best.bound) break;
    consider(bodies, positions, line, here, best);
  }
  return best.exit;
}

}  // namespace palpate

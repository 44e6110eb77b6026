#include "contact/silhouette.hpp"

#include <algorithm>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

constexpr std::size_t most_triangles = 256;
/// Relative to the length of an edge: a line nearer to it than this leaves across it, regardless of rounding.
constexpr double at_side = 1e-6;

Vec3 across(const Vec3& a, const Vec3& d) {
  return a - dot(a, d) * d;
}

/// Displacement from the line to an edge of a triangle, as seen along the line; `third` is the triangle's
/// other corner. All points are relative to the line and projected across it.
LineExit exit_over(const Vec3& a, const Vec3& b, const Vec3& third) {
  const Vec3 ab = b - a;
  const double l2 = squared_length(ab);
  const double t = l2 > 0.0 ? std::clamp(-dot(a, ab) / l2, 0.0, 1.0) : 0.0;
  const Vec3 offset = a + t * ab;
  const double distance = length(offset);
  if (distance * distance > at_side * at_side * l2) return {distance, (1.0 / distance) * offset};
  const Vec3 inward = third - a;
  const Vec3 outward = l2 > 0.0 ? (dot(inward, ab) / l2) * ab - inward : -inward;
  return {distance, normalized(outward)};
}

bool has_end(const Triangle& triangle, const Edge& edge) {
  return std::ranges::any_of(triangle, [&](Index p) { return p == edge[0] || p == edge[1]; });
}

}  // namespace

bool SilhouetteSearch::has_reached(Index triangle) const {
  return std::ranges::find(reached_, triangle) != reached_.end();
}

void SilhouetteSearch::look_at(const Bodies& bodies, std::span<const Vec3> positions, const EdgeLine& line,
                               const Reached& here, Best& best) {
  const Triangle& corners = at(bodies.triangles(), here.triangle);
  for (std::size_t i = 0; i < 3; ++i) {
    const Index other = at(bodies.triangle_neighbors(), here.triangle)[i];
    if (other >= 0 && other == here.from) continue;
    const auto place = [&](std::size_t k) { return across(at(positions, corners[k]) - line.x, line.d); };
    const LineExit exit = exit_over(place((i + 1) % 3), place((i + 2) % 3), place(i));
    if (exit.distance >= best.bound) continue;
    // A line of the same body: an exit to the surface at the edge itself is none.
    if (other >= 0 && has_end(at(bodies.triangles(), other), line.ends)) continue;
    const bool goes_on =
        other >= 0 && (dot(area_vector(positions, at(bodies.triangles(), other)), line.d) > 0.0) == ahead_;
    if (!goes_on) {
      const double bound = exit.distance + line.allowance(exit.direction);
      if (bound < best.bound) best = {exit, bound};
    } else if (!has_reached(other)) {
      reached_.push_back(other);
      heap_.push_back({exit.distance, other, here.triangle});
      std::ranges::push_heap(heap_, std::greater{}, &Reached::distance);
    }
  }
}

LineExit SilhouetteSearch::nearest(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                   const EdgeLine& line, double limit) {
  ahead_ = dot(area_vector(positions, at(bodies.triangles(), triangle)), line.d) > 0.0;
  Best best{{}, limit};
  heap_.assign(1, {0.0, triangle, -1});
  reached_.assign(1, triangle);
  while (!heap_.empty() && reached_.size() < most_triangles) {
    std::ranges::pop_heap(heap_, std::greater{}, &Reached::distance);
    const Reached here = heap_.back();
    heap_.pop_back();
    if (here.distance >= best.bound) break;
    look_at(bodies, positions, line, here, best);
  }
  return best.exit;
}

}  // namespace palpate

#include "self_intersections.hpp"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <algorithm>
#include <boost/variant/get.hpp>
#include <utility>
#include <vector>

#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using TriangleBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::size_t>;

Kernel::Point_3 point_of(const Surface& surface, Index p) {
  const Vec3& place = at(surface.points, p);
  return {place.x, place.y, place.z};
}

Kernel::Triangle_3 triangle_of(const Surface& surface, const Triangle& t) {
  return {point_of(surface, t[0]), point_of(surface, t[1]), point_of(surface, t[2])};
}

/// Whether the edge of `t` opposite to its corner intersects the other triangle.
bool far_edge_cuts(const Surface& surface, const Triangle& t, std::size_t corner, const Triangle& other) {
  const Kernel::Segment_3 edge(point_of(surface, t[(corner + 1) % 3]),
                               point_of(surface, t[(corner + 2) % 3]));
  return CGAL::do_intersect(edge, triangle_of(surface, other));
}

bool meet(const Surface& surface, const Triangle& a, const Triangle& b) {
  std::vector<std::pair<std::size_t, std::size_t>> common;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (a[i] == b[j]) common.emplace_back(i, j);
    }
  }
  if (common.size() > 1) return false;
  if (common.size() == 1) {
    return far_edge_cuts(surface, a, common[0].first, b) || far_edge_cuts(surface, b, common[0].second, a);
  }
  return CGAL::do_intersect(triangle_of(surface, a), triangle_of(surface, b));
}

std::array<Vec3, 2> line_of(const Surface& surface, const Triangle& a, const Triangle& b) {
  const auto place = [](const Kernel::Point_3& p) { return Vec3{p.x(), p.y(), p.z()}; };
  const auto common = CGAL::intersection(triangle_of(surface, a), triangle_of(surface, b));
  if (common) {
    if (const auto* line = boost::get<Kernel::Segment_3>(&*common)) {
      return {place(line->source()), place(line->target())};
    }
    if (const auto* point = boost::get<Kernel::Point_3>(&*common)) return {place(*point), place(*point)};
  }
  // They are coplanar, or the segment where they meet was lost by rounding.
  const Vec3 middle =
      (1.0 / 3.0) * (at(surface.points, a[0]) + at(surface.points, a[1]) + at(surface.points, a[2]));
  return {middle, middle};
}

}  // namespace

SelfIntersections self_intersections(const Surface& surface) {
  std::vector<TriangleBox> boxes;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Kernel::Triangle_3 triangle = triangle_of(surface, surface.triangles[t]);
    if (!triangle.is_degenerate()) boxes.emplace_back(triangle.bbox(), t);
  }
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const TriangleBox& a, const TriangleBox& b) {
    const std::pair<std::size_t, std::size_t> pair = std::minmax({a.info(), b.info()});
    if (meet(surface, surface.triangles[pair.first], surface.triangles[pair.second])) pairs.push_back(pair);
  });
  std::ranges::sort(pairs);
  SelfIntersections result{pairs.size(), {}};
  for (const auto& [a, b] : pairs)
    result.segments.push_back(line_of(surface, surface.triangles[a], surface.triangles[b]));
  return result;
}

}  // namespace palpate::app

#include "contact/local_thickness.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "contact/nearest_surface.hpp"
#include "contact/rim_falloff.hpp"
#include "geometry/triangle.hpp"

namespace palpate {
namespace {

/// Barycentric weights of the places on a triangle: its middle, and near its corners.
constexpr double near_corner = 0.6;
constexpr double beside = 0.2;
constexpr std::array<std::array<double, 3>, 4> places{{{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0},
                                                       {near_corner, beside, beside},
                                                       {beside, near_corner, beside},
                                                       {beside, beside, near_corner}}};

double height_of(const Bodies& bodies, const Tet& tet, double area) {
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = at(bodies.points_rest(), tet[i]);
  return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / area;
}

double thickness_behind(const Bodies& bodies, Index triangle, double most) {
  const std::span<const Vec3> rest = bodies.points_rest();
  const std::array<Vec3, 3> x = corners_of(rest, at(bodies.triangles(), triangle));
  const Vec3 area = area_vector(x);
  if (area == Vec3{}) return 0.0;
  const Index tet = at(bodies.triangle_tets(), triangle);
  double least = most;
  for (const auto& [a, b, c] : places) {
    const ExitAhead exit =
        exit_ahead(bodies, rest, tet, a * x[0] + b * x[1] + c * x[2], -normalized(area), least);
    if (exit.leaves()) least = std::min(least, exit.distance);
  }
  return std::min(most, std::max(least, height_of(bodies, at(bodies.tets(), tet), length(area))));
}

}  // namespace

LocalThickness::LocalThickness(const Bodies& bodies, const Clusters& surface)
    : of_triangle(bodies.triangles().size()),
      of_cluster(surface.clusters.size(), std::numeric_limits<double>::infinity()),
      of_point(bodies.points_rest().size()),
      mean_edge(bodies.bodies().size()),
      of_body(bodies.bodies().size(), std::numeric_limits<double>::infinity()) {
  for (Index b = 0; b < bodies.body_count(); ++b) {
    at(mean_edge, b) = rim_reach(bodies, b) / reach_of_an_edge;
    const Range points = at(bodies.bodies(), b).points;
    std::fill(of_point.begin() + points.begin, of_point.begin() + points.end, at(mean_edge, b));
  }
  for (std::size_t c = 0; c < surface.clusters.size(); ++c) {
    const Cluster& cluster = surface.clusters[c];
    for (const Index triangle : surface.primitives_of(cluster)) {
      const double here = thickness_behind(bodies, triangle, at(mean_edge, cluster.body));
      at(of_triangle, triangle) = here;
      of_cluster[c] = std::min(of_cluster[c], here);
      for (const Index corner : at(bodies.triangles(), triangle))
        at(of_point, corner) = std::min(at(of_point, corner), here);
    }
    at(of_body, cluster.body) = std::min(at(of_body, cluster.body), of_cluster[c]);
  }
}

}  // namespace palpate

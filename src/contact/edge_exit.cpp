#include "contact/edge_exit.hpp"

#include <algorithm>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

struct SurfacePlane {
  Vec3 normal;
  double signed_weight;  ///< of an exit > 0, of an entry < 0; not yet normalised to a sum of one
};

}  // namespace

EdgeExit::EdgeExit(const Bodies& bodies, std::span<const Vec3> positions, const SurfaceNormals& normals,
                   const Vec3& p, const Vec3& edge, std::span<const Crossing> crossings) {
  const auto plane_of = [&](const Crossing& c) {
    const Vec3 area = area_vector(positions, at(bodies.triangles(), c.triangle));
    const Vec3 n = normals.at_point(positions, c.triangle, p + c.parameter * edge);
    const double outwards = dot(area, edge) > 0.0 ? 1.0 : -1.0;
    return SurfacePlane{n, outwards * std::max(0.0, dot(n, normalized(edge))) / (1.0 - c.parameter + here)};
  };
  double sum = 0.0;
  const Crossing* last = &crossings.front();
  for (const Crossing& c : crossings) {
    nearest = std::min(nearest, c.parameter);
    if (crossings.size() > 1) sum += plane_of(c).signed_weight;
    if (c.parameter > last->parameter) last = &c;
  }
  at_point = nearest < here;
  distance = nearest * length(edge);
  constexpr double decided = 0.02;  // below it the edge only grazes the surface
  if (crossings.size() > 1 && (sum > decided || at_point)) {
    for (const Crossing& c : crossings) {
      const SurfacePlane plane = plane_of(c);
      if (at_point && c.parameter >= here) continue;
      const double fraction = at_point ? 1.0 : plane.signed_weight / sum;
      add(edge, c, plane.normal, fraction);
    }
    if (weight > 0.0) return;
    weight = depth = 0.0;
    normal = {};
  }
  add(edge, *last, plane_of(*last).normal, 1.0);
}

EdgeExit::EdgeExit(const Vec3& edge, const Crossing& crossing, const Vec3& surface_normal)
    : nearest(std::min(1.0, crossing.parameter)), distance(nearest * length(edge)), at_point(nearest < here) {
  add(edge, crossing, surface_normal, 1.0);
}

void EdgeExit::add(const Vec3& edge, const Crossing& c, const Vec3& n, double fraction) {
  const double w = at_point ? fraction : fraction * (1.0 / (c.parameter * c.parameter) - (1.0 - link_weight));
  weight += w;
  depth += w * c.parameter * dot(edge, n);
  normal += w * n;
}

}  // namespace palpate

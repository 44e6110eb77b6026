#include "contact/edge_exit.hpp"

#include <algorithm>

#include "geometry/triangle.hpp"

namespace palpate {
EdgeExit::EdgeExit(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& edge,
                   std::span<const Crossing> crossings, std::span<const Vec3> normals) {
  std::size_t last = 0;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    nearest = std::min(nearest, crossings[i].parameter);
    if (crossings[i].parameter > crossings[last].parameter) last = i;
  }
  at_point = nearest < here;
  distance = nearest * length(edge);
  if (crossings.size() > 1) add_all(bodies, positions, edge, crossings, normals);
  if (weight > 0.0) return;
  weight = depth = 0.0;
  normal = {};
  add(edge, crossings[last], normals[last], 1.0);
}

/// Adds several crossings, unless the edge only grazes the surface.
void EdgeExit::add_all(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& edge,
                       std::span<const Crossing> crossings, std::span<const Vec3> normals) {
  constexpr double decided = 0.02;
  const Vec3 unit = normalized(edge);
  // Weight of an exit > 0, of an entry < 0; not yet normalised to a sum of one.
  const auto signed_weight = [&](std::size_t i) {
    const Vec3 area = area_vector(positions, at(bodies.triangles(), crossings[i].triangle));
    const double outwards = dot(area, edge) > 0.0 ? 1.0 : -1.0;
    return outwards * std::max(0.0, dot(normals[i], unit)) / (1.0 - crossings[i].parameter + here);
  };
  double sum = 0.0;
  for (std::size_t i = 0; i < crossings.size(); ++i) sum += signed_weight(i);
  if (!(sum > decided || at_point)) return;
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    if (at_point && crossings[i].parameter >= here) continue;
    add(edge, crossings[i], normals[i], at_point ? 1.0 : signed_weight(i) / sum);
  }
}

void EdgeExit::add(const Vec3& edge, const Crossing& c, const Vec3& n, double fraction) {
  const double w = at_point ? fraction : fraction * (1.0 / (c.parameter * c.parameter) - (1.0 - link_weight));
  weight += w;
  depth += w * c.parameter * dot(edge, n);
  normal += w * n;
}

}  // namespace palpate

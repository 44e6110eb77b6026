#include "contact/layers.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "mesh/faces.hpp"

namespace palpate {
namespace {

/// Whether a tet has the point or one of its neighbours as a corner.
bool touches_neighborhood(const Bodies& bodies, const Tet& tet, Index point) {
  if (has_corner(tet, point)) return true;
  const auto edges = bodies.point_edges()[point];
  return std::any_of(edges.begin(), edges.end(),
                     [&](Index edge) { return has_corner(tet, bodies.other_end(edge, point)); });
}

}  // namespace

bool is_fold(const Bodies& bodies, std::span<const Vec3> positions, Index point, Index tet) {
  for (const Index corner : at(bodies.tets(), tet)) {
    for (const Index other : bodies.point_tets()[corner]) {
      const Tet& t = at(bodies.tets(), other);
      if (orient3d(at(positions, t[0]), at(positions, t[1]), at(positions, t[2]), at(positions, t[3])) > 0)
        continue;
      if (touches_neighborhood(bodies, t, point)) return true;
    }
  }
  return false;
}

bool same_layer(const Bodies& bodies, std::span<const Vec3> positions, Index point_a, Index tet_a,
                Index point_b, Index tet_b) {
  if (tet_b < tet_a) {
    std::swap(point_a, point_b);
    std::swap(tet_a, tet_b);
  }
  const Tet& goal = at(bodies.tets(), tet_b);
  for (const Index corner : at(bodies.tets(), tet_a)) {
    if (has_corner(goal, corner)) return true;
  }
  const Vec3& a = at(positions, point_a);
  const Vec3& b = at(positions, point_b);
  std::array<Index, 64> reached{tet_a};
  std::size_t count = 1;
  for (std::size_t next = 0; next < count; ++next) {
    const Tet& t = at(bodies.tets(), reached[next]);
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const Index neighbor = at(bodies.tet_neighbors(), reached[next])[opposite];
      const auto seen = std::span(reached).first(count);
      if (neighbor < 0 || count == reached.size() ||
          std::find(seen.begin(), seen.end(), neighbor) != seen.end())
        continue;
      const auto& [i, j, k] = outward_face[opposite];
      if (!segment_meets_triangle(a, b, at(positions, t[i]), at(positions, t[j]), at(positions, t[k])))
        continue;
      if (neighbor == tet_b) return true;
      reached[count++] = neighbor;
    }
  }
  return false;
}

}  // namespace palpate

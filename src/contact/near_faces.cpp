#include "contact/near_faces.hpp"

#include <algorithm>
#include <limits>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

bool has(const auto& corners, Index point) {
  return std::find(corners.begin(), corners.end(), point) != corners.end();
}

}  // namespace

void NearFaces::add(std::uint32_t point, Index tet) {
  Walk& walk = walks_[point];
  pairs_.push_back({point, tet});
  before_.push_back(walk.last);
  walk.last = static_cast<std::uint32_t>(pairs_.size() - 1);
  ++walk.tets;
}

bool NearFaces::has_reached(const Walk& walk, Index tet) const {
  for (std::uint32_t pair = walk.last; pair != none; pair = before_[pair])
    if (pairs_[pair].tet == tet) return true;
  return false;
}

/// Lists the near faces of a tet that are at the surface; goes through the others.
void NearFaces::visit(const Bodies& bodies, std::span<const Point> points, std::uint32_t pair) {
  const auto [point, tet] = pairs_[pair];
  Walk& walk = walks_[point];
  const std::array<double, 4>& squared = squared_[pair];
  const std::array<Index, 4>& neighbors = at(bodies.tet_neighbors(), tet);
  const Index without = points[point].without;
  for (std::uint32_t k = 0; k < 4; ++k) {
    if (neighbors[k] >= 0 || !(squared[k] < walk.radius2)) continue;
    if (without >= 0 && has(at(bodies.triangles(), bodies.triangle_of_face(tet, k)), without)) continue;
    if (squared[k] < walk.reach2) found_.push_back({point, tet, k});
    nearest_[point] = std::min(nearest_[point], squared[k]);
    walk.radius2 = std::max(walk.reach2, nearest_[point]);
  }
  for (std::uint32_t k = 0; k < 4; ++k) {
    const Index neighbor = neighbors[k];
    if (neighbor < 0 || !(squared[k] < walk.radius2) || has_reached(walk, neighbor)) continue;
    if (without >= 0 && has(at(bodies.tets(), neighbor), without)) continue;
    if (walk.tets < most_tets) {
      add(point, neighbor);
    } else {
      nearest_[point] = given_up;
      walk.radius2 = 0.0;
    }
  }
}

void NearFaces::find(const Bodies& bodies, std::span<const Vec3> positions, std::span<const Vec3> places,
                     std::span<const Index> tets, std::span<const Point> points) {
  pairs_.clear();
  before_.clear();
  found_.clear();
  resize_with_room(walks_, points.size());
  assign_with_room(nearest_, points.size(), std::numeric_limits<double>::infinity());
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    const double reach2 = points[p].reach * points[p].reach;
    walks_[p] = {reach2, std::max(reach2, points[p].bound * points[p].bound), none, 0};
    add(p, tets[p]);
  }
  for (std::size_t begin = 0; begin < pairs_.size();) {
    const std::size_t end = pairs_.size();
    squared_.resize(end);
    simd::find_face_distances(positions, bodies.tets(), places, std::span(pairs_).subspan(begin, end - begin),
                              std::span(squared_).subspan(begin));
    for (; begin < end; ++begin) visit(bodies, points, static_cast<std::uint32_t>(begin));
  }
}

}  // namespace palpate

#include "contact/near_faces.hpp"

#include <algorithm>

#include "contact/nearest_surface.hpp"
#include "mesh/faces.hpp"
#include "room.hpp"

namespace palpate {
namespace {

bool has(const auto& corners, Index point) {
  return std::find(corners.begin(), corners.end(), point) != corners.end();
}

/// Faces at a distance are visited although rounding puts them a little beyond it.
double rounded_up(double squared) {
  return squared * (1.0 + 1e-12);
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

/// Goes through the near faces of a tet. Calls found(walk, face) for those at the surface.
template <class Found>
void NearFaces::visit(const Frame& frame, std::uint32_t pair, Found&& found) {
  const auto [point, tet] = pairs_[pair];
  const std::array<double, 4>& squared = squared_[pair];
  const std::array<Index, 4>& neighbors = at(frame.bodies.tet_neighbors(), tet);
  const Index without = frame.points[point].without;
  for (std::size_t k = 0; k < 4; ++k) {
    if (!(squared[k] < walks_[point].radius2)) continue;
    const Index neighbor = neighbors[k];
    if (neighbor >= 0) {
      if (has_reached(walks_[point], neighbor)) continue;
      if (without >= 0 && has(at(frame.bodies.tets(), neighbor), without)) continue;
      if (walks_[point].tets < most_tets) {
        add(point, neighbor);
      } else {
        walks_[point].gave_up = true;
        walks_[point].radius2 = 0.0;
      }
      continue;
    }
    const Index triangle = frame.bodies.triangle_of_face(tet, k);
    if (without >= 0 && has(at(frame.bodies.triangles(), triangle), without)) continue;
    const Tet& corners = at(frame.bodies.tets(), tet);
    const auto& [a, b, c] = outward_face[k];
    const std::array<Vec3, 3> face{at(frame.positions, corners[a]), at(frame.positions, corners[b]),
                                   at(frame.positions, corners[c])};
    // A face without area: its edges belong to its neighbours too.
    if (cross(face[1] - face[0], face[2] - face[0]) == Vec3{}) continue;
    const Vec3 x = nearest_on_triangle(frame.places[point], face);
    found(walks_[point], Face{point, triangle, length(x - frame.places[point]), x});
  }
}

template <class Found>
void NearFaces::walk_on(const Frame& frame, std::size_t begin, Found&& found) {
  while (begin < pairs_.size()) {
    const std::size_t end = pairs_.size();
    squared_.resize(end);
    simd::find_face_distances(frame.positions, frame.bodies.tets(), frame.places,
                              std::span(pairs_).subspan(begin, end - begin),
                              std::span(squared_).subspan(begin));
    for (; begin < end; ++begin) visit(frame, static_cast<std::uint32_t>(begin), found);
  }
}

void NearFaces::find(const Frame& frame) {
  pairs_.clear();
  before_.clear();
  found_.clear();
  resize_with_room(walks_, frame.points.size());
  for (std::uint32_t p = 0; p < frame.points.size(); ++p) {
    const double reach = frame.points[p].reach;
    walks_[p] = {rounded_up(reach * reach), 0.0, 0.0, none, 0, false};
    add(p, frame.points[p].tet);
  }
  walk_on(frame, 0, [&](const Walk&, const Face& face) {
    if (face.distance < frame.points[face.point].reach) found_.push_back(face);
  });
}

void NearFaces::search_on(const Frame& frame, std::span<const Search> searches) {
  const auto found = [](Walk& walk, const Face& face) {
    if (!(face.distance < walk.nearest)) return;
    walk.nearest = face.distance;
    walk.radius2 = face.distance <= walk.enough ? 0.0 : rounded_up(face.distance * face.distance);
  };
  const std::size_t begin = pairs_.size();
  for (const auto& [point, bound, enough] : searches) {
    Walk& walk = walks_[point];
    walk.radius2 = rounded_up(bound * bound);
    walk.nearest = bound;
    walk.enough = enough;
    std::array<std::uint32_t, most_tets> visited;
    std::size_t count = 0;
    for (std::uint32_t pair = walk.last; pair != none; pair = before_[pair]) visited[count++] = pair;
    while (count > 0) visit(frame, visited[--count], found);
  }
  walk_on(frame, begin, found);
}

}  // namespace palpate

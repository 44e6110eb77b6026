#include "contact/near_faces.hpp"

#include <algorithm>
#include <utility>

#include "contact/nearest_surface.hpp"
#include "mesh/faces.hpp"

namespace palpate {
namespace {

/// The square of a distance, so much larger that no face at the distance is missed because of rounding.
double rounded_up(const NearFaces::Frame& frame, double distance) {
  const double enough = distance * (1.0 + 1e-12) + frame.inexact;
  return enough * enough;
}

}  // namespace

/// Adds a tet to the walk of a point. Its distances may be known; but each walk visits its tets in their
/// order.
void NearFaces::add(std::uint32_t point, Index tet) {
  Walk& walk = walks_[point];
  const std::uint32_t pair = count_++;
  pairs_[pair] = {point, tet, walk.last};
  walk.last = pair;
  ++walk.tets;
  if (walk.known != none && !walk.waits) {
    if (const std::uint32_t known = pair_of(walk.known, tet); known != none) {
      squared_[pair] = squared_[known];
      return;
    }
  }
  walk.waits = true;
  next_.push_back(pair);
}

/// The pair of a point with a tet, of a walk of which `last` is the newest pair.
std::uint32_t NearFaces::pair_of(std::uint32_t last, Index tet) const {
  while (last != none && pairs_[last].tet != tet) last = pairs_[last].before;
  return last;
}

/// Goes through the near faces of a tet. Calls found(walk, face) for those at the surface.
template <class Found>
void NearFaces::visit(const Frame& frame, std::uint32_t pair, Found&& found) {
  const auto [point, tet, before] = pairs_[pair];
  const std::array<double, 4> squared = squared_[pair];
  const std::array<Index, 4>& neighbors = at(frame.bodies.tet_neighbors(), tet);
  const Index without = frame.points[point].without;
  for (std::size_t k = 0; k < 4; ++k) {
    if (!(squared[k] < walks_[point].radius2)) continue;
    const Index neighbor = neighbors[k];
    if (neighbor >= 0) {
      if (pair_of(walks_[point].last, neighbor) != none) continue;
      if (without >= 0 && has_corner(at(frame.bodies.tets(), neighbor), without)) continue;
      if (walks_[point].tets < most_tets) {
        add(point, neighbor);
      } else {
        walks_[point].gave_up = true;
        walks_[point].radius2 = 0.0;
      }
      continue;
    }
    const Index triangle = frame.bodies.triangle_of_face(tet, k);
    if (without >= 0 && has_corner(at(frame.bodies.triangles(), triangle), without)) continue;
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
void NearFaces::walk_on(const Frame& frame, Found&& found) {
  while (!next_.empty()) {
    std::swap(todo_, next_);
    next_.clear();
    simd::find_face_distances(frame.positions, frame.bodies.tets(), frame.places, {pairs_.get(), count_},
                              todo_, {squared_.get(), count_});
    for (const std::uint32_t pair : todo_) visit(frame, pair, found);
  }
}

void NearFaces::find(const Frame& frame) {
  count_ = 0;
  found_.clear();
  next_.clear();
  for (std::uint32_t p = 0; p < frame.points.size(); ++p) {
    const double reach = frame.points[p].reach;
    walks_[p] = {.radius2 = rounded_up(frame, reach)};
    add(p, frame.points[p].tet);
  }
  walk_on(frame, [&](const Walk&, const Face& face) {
    if (face.distance < frame.points[face.point].reach) found_.push_back(face);
  });
}

void NearFaces::search(const Frame& frame, std::span<const Search> searches) {
  const auto found = [&](Walk& walk, const Face& face) {
    if (!(face.distance < walk.nearest)) return;
    walk.nearest = face.distance;
    walk.radius2 = face.distance <= walk.enough ? 0.0 : rounded_up(frame, face.distance);
  };
  next_.clear();
  for (const auto& [point, bound, enough] : searches) {
    walks_[point] = {
        .radius2 = rounded_up(frame, bound), .nearest = bound, .enough = enough, .known = walks_[point].last};
    std::uint32_t pair = count_;
    add(point, frame.points[point].tet);
    const std::size_t waiting = next_.size();
    for (; pair < count_ && (next_.size() == waiting || pair < next_[waiting]); ++pair)
      visit(frame, pair, found);
  }
  walk_on(frame, found);
}

}  // namespace palpate

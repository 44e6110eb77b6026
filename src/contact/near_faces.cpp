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
  next_[waiting_++] = pair;
}

/// The pair of a point with a tet, of a walk of which `last` is the newest pair.
std::uint32_t NearFaces::pair_of(std::uint32_t last, Index tet) const {
  while (last != none && pairs_[last].tet != tet) last = pairs_[last].before;
  return last;
}

/// Goes through the near faces of a tet. Calls found(pair, opposite, distance, nearest point) for those at
/// the surface.
template <class Found>
void NearFaces::visit(const Frame& frame, std::uint32_t pair, Found&& found) {
  const auto [point, tet, before] = pairs_[pair];
  Walk& walk = walks_[point];
  const std::array<double, 4>& squared = squared_[pair];
  const std::array<Index, 4>& neighbors = at(frame.bodies.tet_neighbors(), tet);
  const Index without = frame.points[point].without;
  for (std::size_t k = 0; k < 4; ++k) {
    if (!(squared[k] < walk.radius2)) continue;
    const Index neighbor = neighbors[k];
    if (neighbor >= 0) {
      if (pair_of(walk.last, neighbor) != none) continue;
      if (without >= 0 && has_corner(at(frame.bodies.tets(), neighbor), without)) continue;
      if (walk.tets < most_tets) {
        add(point, neighbor);
      } else {
        walk.gave_up = true;
        walk.radius2 = 0.0;
      }
      continue;
    }
    const Tet& corners = at(frame.bodies.tets(), tet);
    const auto& [a, b, c] = outward_face[k];
    if (without >= 0 && has_corner(Triangle{corners[a], corners[b], corners[c]}, without)) continue;
    const std::array<Vec3, 3> face{at(frame.positions, corners[a]), at(frame.positions, corners[b]),
                                   at(frame.positions, corners[c])};
    // A face without area: its edges belong to its neighbours too.
    const Vec3 normal = cross(face[1] - face[0], face[2] - face[0]);
    if (normal == Vec3{}) continue;
    const Vec3 x = nearest_on_triangle(frame.places[point], face, normal);
    found(pair, k, length(x - frame.places[point]), x);
  }
}

template <class Found>
void NearFaces::walk_on(const Frame& frame, Found&& found) {
  while (waiting_ > 0) {
    std::swap(todo_, next_);
    const std::span<const std::uint32_t> todo(todo_.get(), std::exchange(waiting_, 0));
    simd::find_face_distances(frame.positions, frame.bodies.tets(), frame.places, {pairs_.get(), count_},
                              todo, {squared_.get(), count_});
    for (const std::uint32_t pair : todo) visit(frame, pair, found);
  }
}

void NearFaces::find(const Frame& frame) {
  count_ = static_cast<std::uint32_t>(frame.points.size());
  found_.clear();
  waiting_ = count_;
  for (std::uint32_t p = 0; p < count_; ++p) {
    walks_[p] = {.radius2 = rounded_up(frame, frame.points[p].reach), .last = p, .tets = 1};
    pairs_[p] = {p, frame.points[p].tet, none};
    next_[p] = p;
  }
  walk_on(frame, [&](std::uint32_t pair, std::size_t opposite, double distance, const Vec3& x) {
    const auto& [point, tet, before] = pairs_[pair];
    if (distance < frame.points[point].reach)
      found_.push_back({point, frame.bodies.triangle_of_face(tet, opposite), distance, x});
  });
}

void NearFaces::search(const Frame& frame, std::span<const Search> searches) {
  const auto found = [&](std::uint32_t pair, std::size_t, double distance, const Vec3&) {
    Walk& walk = walks_[pairs_[pair].point];
    if (!(distance < walk.nearest)) return;
    walk.nearest = distance;
    walk.radius2 = distance <= walk.enough ? 0.0 : rounded_up(frame, distance);
  };
  for (const auto& [point, bound, enough] : searches) {
    walks_[point] = {
        .radius2 = rounded_up(frame, bound), .nearest = bound, .enough = enough, .known = walks_[point].last};
    std::uint32_t pair = count_;
    add(point, frame.points[point].tet);
    const std::uint32_t waiting = waiting_;
    for (; pair < count_ && (waiting_ == waiting || pair < next_[waiting]); ++pair) visit(frame, pair, found);
  }
  walk_on(frame, found);
}

}  // namespace palpate

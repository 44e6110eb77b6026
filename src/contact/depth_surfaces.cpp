// The surface near contacts: its planes, and its distance where that is larger than their depth
// (DepthEstimate).
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/depth.hpp"
#include "contact/edge_exit.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// If the weight of the planes of a contact exceeds this multiple of the rest, only they count. It also keeps
/// the system well scaled.
constexpr double alone = 1e8;

}  // namespace

/// Search distance for surface beside a contact. At this distance triangles begin to outweigh all other
/// planes. If a point approaches the surface from inside, far from its border edges, its plane must change
/// before the point leaves the body.
double DepthEstimate::reach(const Estimate& estimate) {
  // This value does not change when a neighbour enters the body.
  const double others = estimate.edges + (estimate.border_weight - link_weight * estimate.border_edges);
  return 1.0 / std::sqrt(others);
}

/// Finds the surface within reach of a chunk of contacts.
void DepthEstimate::list_surfaces(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) {
  const Contacts& contacts = frame.table.contacts();
  scratch.contacts.clear();
  scratch.places.clear();
  scratch.walks.clear();
  for (std::size_t c = begin; c < end; ++c) {
    // A fixed contact is on the surface.
    if (estimates_[c].fixed || frame.cache.source(c) != PlaneCache::compute) continue;
    scratch.contacts.push_back(c);
    scratch.places.push_back(at(frame.positions, contacts.point[c]));
    scratch.walks.push_back({contacts.tet[c], own_point(frame, c), reach(estimates_[c])});
  }
  scratch.near.find(near_frame(frame, scratch));
  scratch.points.clear();
  scratch.beside.clear();
  for (const NearFaces::Face& face : scratch.near.found())
    if (!scratch.near.gave_up(face.point)) add_beside(face, scratch);
  for (std::uint32_t i = 0; i < scratch.contacts.size(); ++i) {
    if (!scratch.near.gave_up(i)) continue;
    const auto& [tet, without, reach] = scratch.walks[i];
    scratch.search.for_each_face(frame.bodies, frame.positions, tet, scratch.places[i], without, reach,
                                 [&](Index of, std::size_t opposite, const Vec3& x, double distance) {
                                   const Index triangle = frame.bodies.triangle_of_face(of, opposite);
                                   add_beside({i, triangle, distance, x}, scratch);
                                 });
  }
}

void DepthEstimate::add_beside(const NearFaces::Face& face, Scratch& scratch) {
  normals_.want(face.triangle);
  scratch.points.push_back({face.triangle, face.x, face.distance});
  scratch.beside.push_back({face.point, face.distance});
}

/// Adds the planes of the surface beside a chunk of contacts.
void DepthEstimate::add_surfaces(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) {
  constexpr double smallest_part = 1e-12;
  const std::size_t n = scratch.points.size();
  grow_to(scratch.normals, n);
  grow_to(scratch.doubtful, n);
  normals_.at_points(frame.positions, scratch.points, scratch.normals, scratch.doubtful);
  for (std::size_t i = 0; i < n; ++i) {
    const auto& [point, distance] = scratch.beside[i];
    Estimate& estimate = estimates_[scratch.contacts[point]];
    const double reach = scratch.walks[point].reach;
    const double excess = 1.0 / std::max(distance, smallest_part * reach) - 1.0 / reach;
    const double weight = excess * excess;
    estimate.nearest_surface = std::min(estimate.nearest_surface, distance);
    estimate.border_weight += weight;
    estimate.depth += weight * dot(scratch.points[i].x - scratch.places[point], scratch.normals[i]);
    estimate.normal += weight * scratch.normals[i];
  }
  for (std::size_t c = begin; c < end; ++c) set_propagation_source(c);
}

/// The first guess of a contact that has planes of its own: their mean.
void DepthEstimate::set_propagation_source(std::size_t c) {
  Estimate& estimate = estimates_[c];
  const double of_crossings = estimate.crossing_weight;
  system_.nodes[c].diagonal = (of_crossings + estimate.links) + (estimate.border_weight - of_crossings);
  if (!(estimate.border_weight > 0.0)) return;
  estimate.depth /= estimate.border_weight;
  estimate.normal = (1.0 / estimate.border_weight) * estimate.normal;
  levels_[c] = 0;
  estimate.fixed |= estimate.border_weight > alone * estimate.links;
}

/// Raises the depths of `scratch.raise` to the distance of the surface.
void DepthEstimate::raise_depths(const Frame& frame, Scratch& scratch) {
  scratch.searches.clear();
  std::uint32_t i = 0;
  for (const std::size_t c : scratch.raise) {
    const double enough = this->enough(frame, c);
    const double bound = surface_bound(frame, c, enough);
    if (bound <= enough) continue;
    while (i < scratch.contacts.size() && scratch.contacts[i] < c) ++i;
    const bool is_known = i < scratch.contacts.size() && scratch.contacts[i] == c && !scratch.near.gave_up(i);
    if (is_known && bound <= system_.nodes[c].length) {
      scratch.searches.push_back({i, bound, enough});
    } else {
      search_surface(frame, c, {0, bound, enough}, scratch.search);
    }
  }
  scratch.near.search(near_frame(frame, scratch), scratch.searches);
  for (const NearFaces::Search& search : scratch.searches) {
    const std::size_t c = scratch.contacts[search.point];
    if (scratch.near.gave_up(search.point)) {
      search_surface(frame, c, search, scratch.search);
    } else {
      raise_depth(frame, c, scratch.near.nearest(search.point), search.enough);
    }
  }
}

/// An upper bound of the distance from the surface: its distance along a few directions. Not more than
/// `enough` if one of them shows that no search is needed.
double DepthEstimate::surface_bound(const Frame& frame, std::size_t c, double enough) const {
  const Contacts& contacts = frame.table.contacts();
  const Vec3& p = at(frame.positions, contacts.point[c]);
  double bound = estimates_[c].nearest_crossing;
  const auto try_direction = [&](const Vec3& direction) {
    bound = std::min(bound, surface_ahead(frame.bodies, frame.positions, contacts.tet[c], p, direction));
    return bound <= enough;
  };
  if (try_direction(contacts.direction[c])) return bound;
  if (bound > system_.nodes[c].length) {  // a smaller bound makes the search visit far fewer tets
    for (const Vec3& direction :
         {Vec3{1, 0, 0}, Vec3{-1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, -1, 0}, Vec3{0, 0, 1}, Vec3{0, 0, -1}}) {
      if (try_direction(direction)) return bound;
    }
  }
  return bound * (1.0 + 1e-9);  // so that the search includes a point at this distance
}

void DepthEstimate::search_surface(const Frame& frame, std::size_t c, const NearFaces::Search& search,
                                   ExitSearch& one_by_one) {
  const Contacts& contacts = frame.table.contacts();
  const SurfacePoint found = one_by_one.nearest(frame.bodies, frame.positions, contacts.tet[c],
                                                at(frame.positions, contacts.point[c]), own_point(frame, c),
                                                search.bound, search.enough);
  raise_depth(frame, c, found.distance, search.enough);
}

void DepthEstimate::raise_depth(const Frame& frame, std::size_t c, double distance, double enough) {
  if (distance <= enough || !std::isfinite(distance)) return;
  frame.table.contacts().depth[c] = distance;
  if (estimates_[c].from_surface == from_planes) estimates_[c].from_surface = raised;
}

}  // namespace palpate

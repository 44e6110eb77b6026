// The planes of contacts: from their crossings, the surface beside them and their links (DepthEstimate).
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "contact/depth.hpp"
#include "contact/edge_exit.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"
#include "simd/faces_within_reach.hpp"

namespace palpate {
namespace {

/// If the weight of the crossings exceeds this multiple of the rest, only the crossings count. It also keeps
/// the system well scaled.
constexpr double alone = 1e8;
constexpr std::size_t few = 16;
/// Smallest squared length of an edge that is used, relative to its length at rest.
constexpr double smallest = 1e-12;

double longest_squared_edge(const Bodies& bodies) {
  double longest = 0.0;
  for (const auto& [p, q] : bodies.edges())
    longest = std::max(longest, squared_length(at(bodies.points_rest(), q) - at(bodies.points_rest(), p)));
  return longest;
}

}  // namespace

DepthEstimate::DepthEstimate(const Bodies& bodies)
    : normals_(bodies), surely_enough_(smallest * longest_squared_edge(bodies)) {}

double DepthEstimate::longer_distance(const Frame& frame, Index p, Index q, double now) {
  const std::span<const Vec3> rest = frame.bodies.points_rest();
  return std::max(now, smallest * squared_length(at(rest, q) - at(rest, p)));
}

/// Computes the rows of border edges and links of each contact; rows of links have gaps between them.
void DepthEstimate::lay_out(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  const std::size_t n = contacts.size();
  assign_with_room(border_begin_, n + 1, Index{0});
  penetrated_.assign(frame.bodies.bodies().size(), 0);
  for (const BorderEdge& edge : frame.border_edges) ++at(border_begin_, edge.contact + 1);
  for (std::size_t c = 0; c < n; ++c)
    if (frame.cache.source(c) == PlaneCache::compute) at(penetrated_, contacts.body[c]) = 1;
  std::partial_sum(border_begin_.begin(), border_begin_.end(), border_begin_.begin());
  assign_with_room(estimates_, n, Estimate{});
  assign_with_room(system_.nodes, n, PlaneSystem::Node{});
  for (std::size_t c = 0; c < n; ++c) {
    const Range links = frame.links.ranges_of_links()[c];
    system_.nodes[c].begin = links.begin;
    system_.nodes[c].end = links.end;
  }
  resize_with_room(system_.links, frame.links.links().size());
}

void DepthEstimate::assemble(const Frame& frame) {
  normals_.update(frame.threads, frame.bodies, frame.positions, penetrated_);
  const std::size_t chunks = parallel::chunk_count(estimates_.size(), contacts_of_search);
  if (scratches_.size() < chunks) scratches_.resize(chunks + chunks / 8 + 1);
  parallel::for_chunks(frame.threads, estimates_.size(), contacts_of_search,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         assemble_contacts(frame, begin, end, scratches_[chunk]);
                       });
}

void DepthEstimate::assemble_contacts(const Frame& frame, std::size_t begin, std::size_t end,
                                      Scratch& scratch) {
  const bool late = frame.deadline.passed();
  for (std::size_t c = begin; c < end; ++c) estimates_[c].cached = uses_cached_plane(frame, c, late);
  list_crossings(frame, begin, end, scratch);
  resize_with_room(scratch.exits, scratch.crossed.size());
  find_exits(frame.bodies, frame.positions, normals_, scratch.crossed, scratch.exits);
  const EdgeExit* next_exit = scratch.exits.data();
  for (std::size_t c = begin; c < end; ++c) {
    if (!estimates_[c].cached) add_border(frame, c, next_exit);
    add_links(frame, c);
    if (estimates_[c].cached) use_cached_plane(frame, c);
  }
  const std::size_t room_for_points = scratch.points.capacity();
  const std::size_t room_for_beside = scratch.beside.capacity();
  scratch.points.clear();
  scratch.beside.clear();
  list_surfaces(frame, begin, end, scratch);
  keep_room(scratch.points, room_for_points, scratch.points.size() + few);
  keep_room(scratch.beside, room_for_beside, scratch.beside.size() + few);
  find_normals(frame, scratch);
  std::size_t next = 0;
  for (std::size_t c = begin; c < end; ++c) {
    add_surface(frame, c, scratch, next);
    set_propagation_source(c);
  }
}

void DepthEstimate::find_normals(const Frame& frame, Scratch& scratch) const {
  scratch.normals.reserve(scratch.points.capacity());
  scratch.normals.resize(scratch.points.size());
  normals_.at_points(frame.bodies, frame.positions, scratch.points, scratch.normals);
}

/// Lists the crossings of border edges with exactly one crossing, which are nearly all.
void DepthEstimate::list_crossings(const Frame& frame, std::size_t begin, std::size_t end,
                                   Scratch& scratch) const {
  const Contacts& contacts = frame.table.contacts();
  scratch.crossed.clear();
  make_room(scratch.crossed, static_cast<std::size_t>(border_begin_[end] - border_begin_[begin]));
  for (std::size_t c = begin; c < end; ++c) {
    if (estimates_[c].cached) continue;
    for (Index e = border_begin_[c]; e < border_begin_[c + 1]; ++e) {
      const Index first = at(frame.crossings.begin(), e);
      if (at(frame.crossings.begin(), e + 1) - first != 1) continue;
      const Crossing& crossing = at(frame.crossings.all(), first);
      scratch.crossed.push_back(
          {contacts.point[c], at(frame.border_edges, e).free_point, crossing.triangle, crossing.parameter});
    }
  }
}

/// The mean plane of the crossings of a contact's border edges. `next_exit` is the first of the edges with
/// one crossing that was not used yet, and advances.
void DepthEstimate::add_border(const Frame& frame, std::size_t c, const EdgeExit*& next_exit) {
  const Index point = frame.table.contacts().point[c];
  // Local sums, which are written to memory once.
  double edges = 0.0;
  double border_edges = 0.0;
  double weight = 0.0;
  double depth = 0.0;
  Vec3 normal;
  double nearest = std::numeric_limits<double>::infinity();
  bool fixed = false;
  const auto add = [&](const EdgeExit& exit, double inverse) {
    nearest = std::min(nearest, exit.distance);
    if (fixed && !exit.at_point) return;
    if (exit.at_point && !fixed) {
      // If a crossing is at the point itself, all others are ignored.
      fixed = true;
      weight = depth = 0.0;
      normal = {};
    }
    border_edges += inverse;
    const double scale = exit.at_point ? 1.0 : inverse;
    weight += scale * exit.weight;
    depth += scale * exit.depth;
    normal += scale * exit.normal;
  };
  for (Index e = border_begin_[c]; e < border_begin_[c + 1]; ++e) {
    const Index free_point = at(frame.border_edges, e).free_point;
    const double inverse = 1.0 / squared_distance(frame, point, free_point);
    edges += inverse;
    const auto first = static_cast<std::size_t>(at(frame.crossings.begin(), e));
    const auto last = static_cast<std::size_t>(at(frame.crossings.begin(), e + 1));
    if (last - first == 1) {
      add(*next_exit++, inverse);
    } else if (first == last) {
      ++estimates_[c].without_crossing;
    } else {
      const Vec3& p = at(frame.positions, point);
      add(EdgeExit(frame.bodies, frame.positions, normals_, p, at(frame.positions, free_point) - p,
                   frame.crossings.all().subspan(first, last - first)),
          inverse);
    }
  }
  Estimate& estimate = estimates_[c];
  estimate.edges = edges;
  estimate.border_edges = border_edges;
  estimate.border_weight = weight;
  estimate.nearest_crossing = nearest;
  estimate.nearest_surface = std::numeric_limits<double>::infinity();
  estimate.fixed = fixed;
  estimate.depth = depth;
  estimate.normal = normal;
}

/// Search distance for surface beside a contact. At this distance triangles begin to outweigh all other
/// planes. If a point approaches the surface from inside, far from its border edges, its plane must change
/// before the point leaves the body.
double DepthEstimate::reach(const Estimate& estimate) {
  // This value does not change when a neighbour enters the body.
  const double others = estimate.edges + (estimate.border_weight - link_weight * estimate.border_edges);
  return 1.0 / std::sqrt(others);
}

/// Finds the surface beside up to as many contacts as there are lanes. For most of them, the reach ends
/// inside their tet.
void DepthEstimate::list_surfaces(const Frame& frame, std::size_t begin, std::size_t end,
                                  Scratch& scratch) const {
  const Contacts& contacts = frame.table.contacts();
  simd::ReachingPoints points;
  static_assert(contacts_of_search <= simd::ReachingPoints::most);
  for (std::size_t c = begin; c < end; ++c) {
    points.point.put(at(frame.positions, contacts.point[c]), c - begin);
    const Tet& tet = at(frame.bodies.tets(), contacts.tet[c]);
    for (std::size_t i = 0; i < 4; ++i) points.corner[i].put(at(frame.positions, tet[i]), c - begin);
    points.reach[c - begin] = reach(estimates_[c]);
  }
  simd::find_faces_within_reach(points, end - begin);
  for (std::size_t c = begin; c < end; ++c) {
    if (points.meets[c - begin] == 0.0 || estimates_[c].fixed)
      continue;  // fixed: the point is on the surface
    if (frame.cache.source(c) != PlaneCache::compute) continue;
    list_surface(frame, c, points.reach[c - begin], scratch);
  }
}

void DepthEstimate::list_surface(const Frame& frame, std::size_t c, double reach, Scratch& scratch) const {
  const Contacts& contacts = frame.table.contacts();
  constexpr double smallest_part = 1e-12;
  scratch.search.for_each_face(
      frame.bodies, frame.positions, contacts.tet[c], at(frame.positions, contacts.point[c]),
      own_point(frame, c), reach, [&](Index tet, std::size_t opposite, const Vec3& x, double distance) {
        const double excess = 1.0 / std::max(distance, smallest_part * reach) - 1.0 / reach;
        scratch.points.push_back({frame.bodies.triangle_of_face(tet, opposite), x});
        scratch.beside.push_back({c, distance, excess * excess});
      });
}

/// Adds the planes of surface triangles to a contact. `next` is the index of its first one, and advances to
/// the next contact.
void DepthEstimate::add_surface(const Frame& frame, std::size_t c, const Scratch& scratch,
                                std::size_t& next) {
  Estimate& estimate = estimates_[c];
  PlaneSystem::Node& node = system_.nodes[c];
  if (estimate.fixed) return;
  const Vec3& p = at(frame.positions, frame.table.contacts().point[c]);
  const double border = estimate.border_weight;
  const double links = node.diagonal - border;
  for (; next < scratch.beside.size() && scratch.beside[next].contact == c; ++next) {
    const auto& [contact, distance, weight] = scratch.beside[next];
    const Vec3& normal = scratch.normals[next];
    estimate.nearest_surface = std::min(estimate.nearest_surface, distance);
    estimate.border_weight += weight;
    estimate.depth += weight * dot(scratch.points[next].x - p, normal);
    estimate.normal += weight * normal;
  }
  node.diagonal += estimate.border_weight - border;
  estimate.fixed = estimate.border_weight > alone * links;
}

/// The first guess of a contact that has planes of its own: their mean.
void DepthEstimate::set_propagation_source(std::size_t c) {
  Estimate& estimate = estimates_[c];
  if (!(estimate.border_weight > 0.0)) return;
  estimate.depth /= estimate.border_weight;
  estimate.normal = (1.0 / estimate.border_weight) * estimate.normal;
  estimate.level = 0;
}

/// After the deadline, a contact uses its cached plane if there is one.
bool DepthEstimate::uses_cached_plane(const Frame& frame, std::size_t c, bool late) {
  return frame.cache.source(c) == PlaneCache::cached || (late && frame.cache.plane(c) != nullptr);
}

/// A cached plane is treated like a crossing at the point itself.
void DepthEstimate::use_cached_plane(const Frame& frame, std::size_t c) {
  Estimate& estimate = estimates_[c];
  estimate.depth = frame.cache.plane(c)->depth;
  estimate.normal = frame.cache.plane(c)->direction;
  estimate.fixed = true;
  estimate.level = 0;
}

/// Adds links to the neighbours in contact with the same body.
void DepthEstimate::add_links(const Frame& frame, std::size_t c) {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[c];
  PlaneSystem::Node& node = system_.nodes[c];
  double weight = 0.0;
  for (Index l = node.begin; l < node.end; ++l) {
    const Index neighbor = at(frame.links.links(), l);
    const double link = link_weight / squared_distance(frame, point, at(contacts.point, neighbor));
    at(system_.links, l) = {neighbor, link};
    weight += link;
  }
  Estimate& estimate = estimates_[c];
  estimate.edges += weight / link_weight;
  node.diagonal = estimate.border_weight + weight;
  const Index edges = node.end - node.begin + border_begin_[c + 1] - border_begin_[c];
  node.length = std::sqrt(static_cast<double>(edges) / estimate.edges);
  // Relative to a point of the same body, so that no digits are lost far from the origin.
  node.place =
      at(frame.positions, point) -
      at(frame.positions, at(frame.bodies.bodies(), at(frame.bodies.body_of_point(), point)).points.begin);
}

}  // namespace palpate

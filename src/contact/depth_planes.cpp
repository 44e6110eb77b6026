// The planes of contacts: from their crossings, the surface beside them and their links (DepthEstimate).
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "contact/depth.hpp"
#include "contact/edge_exit.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Smallest squared length of an edge that is used, relative to its length at rest.
constexpr double smallest = 1e-12;

/// How far a crossing is from the nearer end of its edge, relative to the length of the edge. So that planes
/// are continuous when either end enters or leaves, its normal is that for this distance.
double nearer_end(double parameter) {
  return std::max(0.0, std::min(parameter, 1.0 - parameter));
}

double longest_squared_edge(const Bodies& bodies) {
  double longest = 0.0;
  for (const auto& [p, q] : bodies.edges())
    longest = std::max(longest, squared_length(at(bodies.points_rest(), q) - at(bodies.points_rest(), p)));
  return longest;
}

}  // namespace

DepthEstimate::DepthEstimate(const Bodies& bodies)
    : normals_(bodies),
      surely_enough_(smallest * longest_squared_edge(bodies)),
      inexact_(1e-14 * std::sqrt(longest_squared_edge(bodies))) {}

double DepthEstimate::longer_distance(const Frame& frame, Index p, Index q, double now) {
  const std::span<const Vec3> rest = frame.bodies.points_rest();
  return std::max(now, smallest * squared_length(at(rest, q) - at(rest, p)));
}

/// Computes the rows of border edges and links of each contact; rows of links have gaps between them.
void DepthEstimate::lay_out(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  const std::size_t n = contacts.size();
  const std::span<const BorderEdge> edges = frame.border_edges;
  constexpr std::size_t edge_grain = 4096;
  resize_with_room(border_begin_, n + 1);
  parallel::for_chunks(frame.threads, edges.size(), edge_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         Index* const begin_of = border_begin_.data();
                         Index next = begin > 0 ? edges[begin - 1].contact + 1 : 0;
                         for (std::size_t e = begin; e < end; ++e) {
                           const Index contact = edges[e].contact;
                           for (; next < contact; ++next)
                             begin_of[next] = static_cast<Index>(e);  // without border edges
                           if (next == contact) begin_of[next++] = static_cast<Index>(e);
                         }
                       });
  const std::ptrdiff_t with_edges = edges.empty() ? 0 : edges.back().contact + 1;
  std::fill(border_begin_.begin() + with_edges, border_begin_.end(), static_cast<Index>(edges.size()));
  resize_with_room(estimates_, n);
  resize_with_room(levels_, n);
  resize_with_room(system_.nodes, n);
  resize_with_room(system_.links, frame.links.links().size());
}

void DepthEstimate::assemble(const Frame& frame) {
  const std::size_t n = estimates_.size();
  normals_.prepare(frame.threads, frame.positions, frame.crossings.all());
  const std::size_t chunks = parallel::chunk_count(n, contacts_of_search);
  if (scratches_.size() < chunks) scratches_.resize(chunks + chunks / 8 + 1);
  parallel::for_chunks(frame.threads, n, contacts_of_search,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         add_crossings(frame, begin, end, scratches_[chunk]);
                         list_surfaces(frame, begin, end, scratches_[chunk]);
                       });
  normals_.prepare_wanted(frame.threads, frame.positions);  // the surface beside contacts
  parallel::for_chunks(frame.threads, n, contacts_of_search,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         add_surfaces(frame, begin, end, scratches_[chunk]);
                       });
}

/// Adds planes of crossings and links to a chunk of contacts.
void DepthEstimate::add_crossings(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) {
  const bool late = frame.deadline.passed();
  find_planes(frame, at(frame.crossings.begin(), border_begin_[begin]),
              at(frame.crossings.begin(), border_begin_[end]), scratch);
  for (std::size_t c = begin; c < end; ++c) {
    const Range links = frame.links.ranges_of_links()[c];
    std::construct_at(&estimates_[c]);  // in place
    levels_[c] = not_reached;
    system_.nodes[c] = PlaneSystem::Node{.place = {}, .begin = links.begin, .end = links.end};
    estimates_[c].cached = uses_cached_plane(frame, c, late);
    if (!estimates_[c].cached) add_border(frame, c, scratch);
    add_links(frame, c);
    if (estimates_[c].cached) use_cached_plane(frame, c);
  }
}

/// Computes the planes of the crossings [begin, end).
void DepthEstimate::find_planes(const Frame& frame, Index begin, Index end, Scratch& scratch) const {
  const auto n = static_cast<std::size_t>(end - begin);
  const std::span<const Crossing> crossings =
      frame.crossings.all().subspan(static_cast<std::size_t>(begin), n);
  const std::vector<Index>& points = frame.table.contacts().point;
  grow_to(scratch.planes, n);
  grow_to(scratch.doubtful, n);
  scratch.first_crossing = begin;
  scratch.special = false;
  const simd::CrossedEdges edges{points, frame.border_edges, surely_enough_, EdgeExit::here,
                                 1.0 - link_weight};
  const std::size_t doubtful =
      simd::find_planes(edges, normals_.smooth(frame.positions), crossings, scratch.planes, scratch.doubtful);
  for (const simd::Doubtful& d : std::span(scratch.doubtful).first(doubtful)) {
    const Crossing& crossing = crossings[d.item];
    const Index edge = crossing.border_edge;
    // If the edge has other crossings, too, this is done when they are added.
    const bool is_alone = at(frame.crossings.begin(), edge + 1) - at(frame.crossings.begin(), edge) == 1;
    if (!is_alone) continue;
    simd::WeightedPlane& plane = scratch.planes[d.item];
    if (d.valid) {
      use_crease_normal(frame, crossing, d.weights, plane);
    } else {
      plane = unusual_plane(frame, edge, scratch);
      scratch.special = scratch.special || plane.special != 0.0;
    }
  }
}

/// Gives the plane of a crossing near a crease the normal that it has there.
/// \param weights  of the crossing in its triangle
void DepthEstimate::use_crease_normal(const Frame& frame, const Crossing& crossing,
                                      const SurfaceNormals::Weights& weights,
                                      simd::WeightedPlane& plane) const {
  const auto& [contact, free_point] = at(frame.border_edges, crossing.border_edge);
  const Vec3& p = at(frame.positions, at(frame.table.contacts().point, contact));
  const Vec3 displacement = at(frame.positions, free_point) - p;
  const double t = crossing.parameter;
  const Vec3 normal =
      normals_.at_weights(frame.positions, crossing.triangle, weights, nearer_end(t) * length(displacement));
  const double weight = 1.0 / (t * t) - (1.0 - link_weight);
  const double inverse = plane.sums[5];
  const Vec3 weighted = inverse * (weight * normal);
  plane.sums[0] = inverse * (weight * t * dot(displacement, normal));
  plane.sums[1] = weighted.x;
  plane.sums[2] = weighted.y;
  plane.sums[3] = weighted.z;
}

/// Adds the planes of a contact's border edges.
void DepthEstimate::add_border(const Frame& frame, std::size_t c, Scratch& scratch) {
  const auto begin = static_cast<std::size_t>(border_begin_[c]);
  const std::span<const Index> crossings =
      frame.crossings.begin().subspan(begin, static_cast<std::size_t>(border_begin_[c + 1]) - begin + 1);
  const simd::WeightedPlane* plane = scratch.planes.data() + (crossings[0] - scratch.first_crossing);
  BorderSums sums;
  Index next = crossings[0];
  bool is_usual = !scratch.special;
  for (const Index end : crossings.subspan(1)) {
    is_usual = is_usual && end == ++next;
    if (!is_usual) break;
    sums.add(*plane++);
  }
  if (!is_usual) sums = unusual_border(frame, c, scratch);
  Estimate& estimate = estimates_[c];
  estimate.edges = sums.other_edges ? sums.edges : sums.sums[5];
  estimate.depth = sums.sums[0];
  estimate.normal = {sums.sums[1], sums.sums[2], sums.sums[3]};
  estimate.border_weight = estimate.crossing_weight = sums.sums[4];
  estimate.border_edges = sums.sums[5];
  estimate.nearest_crossing = sums.nearest;
  estimate.nearest_surface = std::numeric_limits<double>::infinity();
}

/// The planes of a contact, some of whose border edges have several crossings or none, or a crossing at the
/// point itself.
DepthEstimate::BorderSums DepthEstimate::unusual_border(const Frame& frame, std::size_t c, Scratch& scratch) {
  BorderSums sums;
  sums.other_edges = true;
  Estimate& estimate = estimates_[c];
  for (Index e = border_begin_[c]; e < border_begin_[c + 1]; ++e) {
    const Index first = at(frame.crossings.begin(), e);
    const Index n = at(frame.crossings.begin(), e + 1) - first;
    simd::WeightedPlane plane;
    if (n == 1) plane = at(scratch.planes, first - scratch.first_crossing);
    if (n != 1 || plane.special != 0.0) plane = unusual_plane(frame, e, scratch);
    sums.edges += plane.sums[5];
    estimate.without_crossing += n == 0 ? 1 : 0;
    // If a crossing is at the point itself, all others are ignored.
    if (plane.special != 0.0 && !std::exchange(estimate.fixed, true)) sums.sums = {};
    if (n > 0 && (!estimate.fixed || plane.special != 0.0)) sums.add(plane);
  }
  return sums;
}

/// The plane of a border edge with any number of crossings; `special` where one of them is at the point. Its
/// weight is zero if there is none.
simd::WeightedPlane DepthEstimate::unusual_plane(const Frame& frame, Index edge, Scratch& scratch) const {
  const auto& [contact, free_point] = at(frame.border_edges, edge);
  const Index point = at(frame.table.contacts().point, contact);
  const double inverse = 1.0 / squared_distance(frame, point, free_point);
  const auto first = static_cast<std::size_t>(at(frame.crossings.begin(), edge));
  const auto n = static_cast<std::size_t>(at(frame.crossings.begin(), edge + 1)) - first;
  if (n == 0) return {{0.0, 0.0, 0.0, 0.0, 0.0, inverse}, 0.0, 0.0};
  const std::span<const Crossing> crossings = frame.crossings.all().subspan(first, n);
  const Vec3& p = at(frame.positions, point);
  const Vec3 displacement = at(frame.positions, free_point) - p;
  scratch.normals.clear();
  for (const auto& [border_edge, triangle, parameter] : crossings) {
    const Vec3 x = p + parameter * displacement;
    const double distance = nearer_end(parameter) * length(displacement);
    scratch.normals.push_back(normals_.at_point(frame.positions, triangle, x, distance));
  }
  const EdgeExit of_edge(frame.bodies, frame.positions, displacement, crossings, scratch.normals);
  const double scale = of_edge.at_point ? 1.0 : inverse;
  const Vec3 normal = scale * of_edge.normal;
  return {{scale * of_edge.depth, normal.x, normal.y, normal.z, scale * of_edge.weight, inverse},
          of_edge.distance,
          of_edge.at_point ? 1.0 : 0.0};
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
  levels_[c] = 0;
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
  estimate.links = weight;
  const Index edges = node.end - node.begin + border_begin_[c + 1] - border_begin_[c];
  node.length = std::sqrt(static_cast<double>(edges) / estimate.edges);
  // Relative to a point of the same body, so that no digits are lost far from the origin.
  node.place =
      at(frame.positions, point) -
      at(frame.positions, at(frame.bodies.bodies(), at(frame.bodies.body_of_point(), point)).points.begin);
}

}  // namespace palpate

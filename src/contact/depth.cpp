#include "contact/depth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "contact/edge_exit.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t depth_grain = 256;
/// Fraction of certainty that is lost with each edge of distance from a crossing, so that distant planes
/// count less.
constexpr double loss = 0.01;
/// A mean plane with more certainty than this is trusted.
constexpr double full_certainty = 0.5;
constexpr double least_certainty = 1e-3;
constexpr double tolerance = 1e-5;
constexpr int most_iterations = 200;
constexpr double smallest_normal = 1e-6;
/// The planes count as agreeing if the length of the mean normal is above this.
constexpr double full_agreement = 0.9;

}  // namespace

DepthCounts DepthEstimate::compute(const parallel::Threads& threads, const Bodies& bodies,
                                   std::span<const Vec3> positions, ContactTable& table,
                                   const BorderEdges& border_edges, const Crossings& crossings,
                                   const PlaneCache& cache, const Deadline& deadline) {
  const Frame frame{threads,      bodies,    positions, table,   border_edges.edges(),
                    border_edges, crossings, cache,     deadline};
  lay_out(frame);
  assemble(frame);
  propagate(frame);
  balance(frame);
  finish(frame);
  lead_out(frame);
  return sum_of_counts();
}

/// Counts in a chunk of contacts, after finish_contact() and raise_depths().
void DepthEstimate::count(const Frame& frame, std::size_t begin, std::size_t end, Scratch& scratch) const {
  DepthCounts counts;
  scratch.deep = scratch.unreached = false;
  for (std::size_t c = begin; c < end; ++c) {
    const Estimate& estimate = estimates_[c];
    const std::uint8_t from = estimate.from_surface;
    counts.depth_fallbacks += from == no_border || from == cancelled ? 1 : 0;
    counts.raised_depths += from == raised ? 1 : 0;
    counts.cancelled_directions += from == cancelled ? 1 : 0;
    counts.rough_depths += estimate.rough ? 1 : 0;
    counts.border_edges_without_crossing += static_cast<std::size_t>(estimate.without_crossing);
    scratch.unreached = scratch.unreached || levels_[c] < 0;
    scratch.deep = scratch.deep || is_deep(frame, c);
  }
  scratch.counts = counts;
}

DepthCounts DepthEstimate::sum_of_counts() {
  DepthCounts sum;
  bool unreached = false;
  for (const Scratch& scratch : used_scratches()) {
    const DepthCounts& one = scratch.counts;
    sum.depth_fallbacks += one.depth_fallbacks;
    sum.raised_depths += one.raised_depths;
    sum.cancelled_directions += one.cancelled_directions;
    sum.rough_depths += one.rough_depths;
    sum.border_edges_without_crossing += one.border_edges_without_crossing;
    unreached = unreached || scratch.unreached;
  }
  if (unreached) sum.regions_without_border = static_cast<std::size_t>(regions_not_reached());
  return sum;
}

/// Computes the first guess: breadth-first propagation from the crossings, as in the paper.
void DepthEstimate::propagate(const Frame& frame) {
  if (std::ranges::all_of(levels_, [](Index level) { return level == 0; })) return;
  const std::vector<Index>& point = frame.table.contacts().point;
  frontier_.clear();
  make_room(frontier_, estimates_.size());
  make_room(next_, estimates_.size());
  for (std::size_t c = 0; c < levels_.size(); ++c) {
    if (levels_[c] == 0) frontier_.push_back(static_cast<Index>(c));
  }
  for (Index level = 1; !frontier_.empty(); ++level) {
    next_level(level);
    parallel::for_each(frame.threads, frontier_.size(), depth_grain, [&](std::size_t f) {
      const Index c = frontier_[f];
      const PlaneSystem::Node& node = at(system_.nodes, c);
      Estimate& own = at(estimates_, c);
      double sum = 0.0;
      double depth = 0.0;
      double deepest = 0.0;
      double bound = 0.0;
      Vec3 normal;
      for (Index l = node.begin; l < node.end; ++l) {
        const auto& [neighbor, weight] = at(system_.links, l);
        const Index theirs = at(levels_, neighbor);
        if (theirs < 0 || theirs >= level) continue;
        const Estimate& other = at(estimates_, neighbor);
        const Vec3 offset = at(frame.positions, at(point, neighbor)) - at(frame.positions, at(point, c));
        sum += weight;
        depth += weight * (dot(offset, other.normal) + other.depth);
        normal += weight * other.normal;
        deepest = std::max(deepest, other.depth);
        bound = std::max(bound, other.depth + length(offset));
      }
      own.deepest = deepest;
      own.bound = bound;
      own.depth = depth / sum;
      own.normal = (1.0 / sum) * normal;
    });
  }
}

void DepthEstimate::next_level(Index level) {
  next_.clear();
  for (const Index c : frontier_) {
    const PlaneSystem::Node& node = at(system_.nodes, c);
    for (Index l = node.begin; l < node.end; ++l) {
      const Index other = at(system_.links, l).node;
      if (at(levels_, other) >= 0) continue;
      at(levels_, other) = level;
      next_.push_back(other);
    }
  }
  std::swap(frontier_, next_);
}

/// Makes each plane the mean of the planes linked with it, weighted by their certainty.
void DepthEstimate::balance(const Frame& frame) {
  solve_certainty(frame);
  resize_with_room(planes_, estimates_.size());
  parallel::for_each(frame.threads, estimates_.size(), depth_grain, [&](std::size_t c) {
    const Vec3& normal = estimates_[c].normal;
    planes_[c] = {estimates_[c].depth + dot(system_.nodes[c].place, normal), normal.x, normal.y, normal.z};
  });
  parallel::for_each(frame.threads, estimates_.size(), depth_grain, [&](std::size_t c) {
    PlaneSystem::Node& node = system_.nodes[c];
    node.residual = {};
    if (estimates_[c].fixed) return;
    const Plane& own = planes_[c];
    Plane residual{};
    for (Index l = node.begin; l < node.end; ++l) {
      const auto& [other, link] = at(system_.links, l);
      const Plane& theirs = at(planes_, other);
      const double weight = link * at(estimates_, other).certainty;
      for (std::size_t k = 0; k < own.size(); ++k) residual[k] += weight * (theirs[k] - own[k]);
    }
    node.residual = residual;
    const double size = std::abs(node.residual[0]) + std::abs(node.residual[1]) + std::abs(node.residual[2]) +
                        std::abs(node.residual[3]);
    if (!std::isfinite(size)) leave_out(c);
  });
  system_.solve(frame.threads, tolerance, most_iterations, frame.deadline);
}

/// Computes the certainty of each contact: 1 at a crossing, less with each edge from there. Solves (W_i +
/// sum_j m_ij + s_i) k_i = W_i + sum_j m_ij k_j, starting at 1.
void DepthEstimate::solve_certainty(const Frame& frame) {
  parallel::for_each(frame.threads, estimates_.size(), depth_grain, [&](std::size_t c) {
    PlaneSystem::Node& node = system_.nodes[c];
    const double lost = loss * link_weight * estimates_[c].edges;
    node.diagonal += lost;
    node.residual = {-lost, 0.0, 0.0, 0.0};
    // A contact that uses the mean of its neighbours adds no information to them.
    const bool guesses = frame.cache.source(c) == PlaneCache::neighbors;
    if (levels_[c] < 0 || estimates_[c].fixed || guesses || !std::isfinite(node.diagonal)) leave_out(c);
  });
  system_.solve_numbers(frame.threads, tolerance, most_iterations, frame.deadline);
  parallel::for_each(frame.threads, estimates_.size(), depth_grain, [&](std::size_t c) {
    const bool guesses = frame.cache.source(c) == PlaneCache::neighbors;
    estimates_[c].certainty = guesses ? 0.0 : std::clamp(1.0 + system_.corrections()[c][0], 0.0, 1.0);
  });
}

/// Removes a contact from the system: it keeps its first guess, which its neighbours then use as a given
/// plane. Contacts that propagation did not reach keep their links, which lead only to other contacts of that
/// kind.
void DepthEstimate::leave_out(std::size_t c) {
  PlaneSystem::Node& node = system_.nodes[c];
  node.diagonal = 1.0;
  node.residual = {};
  estimates_[c].fixed = true;
  if (levels_[c] >= 0) node.end = node.begin;
}

void DepthEstimate::finish(const Frame& frame) {
  parallel::for_chunks(frame.threads, estimates_.size(), contacts_of_search,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         const bool rough = frame.deadline.passed();
                         Scratch& scratch = scratches_[chunk];
                         scratch.raise.clear();
                         for (std::size_t c = begin; c < end; ++c) {
                           if (finish_contact(frame, c, rough, scratch.search)) scratch.raise.push_back(c);
                         }
                         raise_depths(frame, scratch);
                         count(frame, begin, end, scratch);
                       });
}

/// Sets depth, direction and certainty of a contact. Returns whether the surface may be further away than its
/// depth, so that its distance must be searched for.
bool DepthEstimate::finish_contact(const Frame& frame, std::size_t c, bool rough, ExitSearch& search) {
  Contacts& contacts = frame.table.contacts();
  Estimate& estimate = estimates_[c];
  if (estimate.cached) {
    estimate.rough = true;
    contacts.depth[c] = estimate.depth;
    contacts.direction[c] = estimate.normal;
    contacts.certainty[c] = frame.cache.plane(c)->certainty;
    return false;
  }
  const Vec3& p = at(frame.positions, contacts.point[c]);
  if (rough && levels_[c] < 0) {
    set_unknown_depth(frame, c);
    return false;
  }
  const Index without = own_point(frame, c);
  const auto nearest = [&] {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    SurfacePoint found =
        search.nearest(frame.bodies, frame.positions, contacts.tet[c], p, without, infinity, -1.0);
    if (found.outward == Vec3{})
      found = nearest_surface_point(frame.bodies, frame.positions, contacts.body[c], p, without);
    if (!std::isfinite(found.distance)) found.distance = 0.0;  // the body has no surface except at the point
    return found;
  };
  const bool guesses = frame.cache.source(c) == PlaneCache::neighbors;
  if (guesses && levels_[c] > 0) {
    use_propagated_depth(frame, c);
    return false;
  }
  const auto& [offset, x, y, z] = system_.corrections()[c];
  const PlaneSystem::Node& node = system_.nodes[c];
  const double scale = 1.0 / std::max(estimate.certainty, least_certainty);
  const Vec3 normal = estimate.normal + scale * Vec3{x, y, z};
  const double mean = estimate.depth + scale * (offset - dot(node.place, {x, y, z}));
  if (levels_[c] < 0 || !std::isfinite(mean) || !is_finite(normal)) {
    const SurfacePoint found = nearest();
    contacts.depth[c] = found.distance;
    contacts.direction[c] = found.outward;
    estimate.from_surface = no_border;
    return false;
  }
  const double agreement = length(normal);
  estimate.mean = std::max(0.0, mean);
  estimate.agreement = agreement;
  contacts.depth[c] = estimate.mean * std::min(1.0, agreement / full_agreement) *
                      std::min(1.0, estimate.certainty / full_certainty);
  contacts.direction[c] = normalized(normal);
  contacts.certainty[c] = std::min(1.0, agreement * estimate.certainty);
  if (agreement < smallest_normal) {
    contacts.certainty[c] = 0.0;
    contacts.direction[c] = nearest().outward;
    estimate.from_surface = cancelled;
  }
  // If many neighbours have no computed plane, their mean is not reliable.
  if (levels_[c] > 0 && frame.cache.spared() > 0)
    contacts.depth[c] = std::min(contacts.depth[c], estimate.bound);
  estimate.rough = rough;
  if (std::min(estimate.nearest_crossing, estimate.nearest_surface) <= enough(frame, c)) return false;
  if (!std::isfinite(estimate.nearest_surface)) return !rough;
  contacts.depth[c] = std::min(estimate.nearest_crossing, estimate.nearest_surface);  // no other is nearer
  if (estimate.from_surface == from_planes) estimate.from_surface = raised;
  return false;
}

/// A difference by rounding alone must not start a search.
double DepthEstimate::enough(const Frame& frame, std::size_t c) const {
  return frame.table.contacts().depth[c] * (1.0 + 1e-9) + 1e-12 * system_.nodes[c].length;
}

/// Uses the mean of the neighbours' planes. The depth is no larger than theirs, since their planes may not be
/// valid further away.
void DepthEstimate::use_propagated_depth(const Frame& frame, std::size_t c) {
  Contacts& contacts = frame.table.contacts();
  Estimate& estimate = estimates_[c];
  const double agreement = length(estimate.normal);
  if (!std::isfinite(estimate.depth) || !(agreement >= smallest_normal)) return set_unknown_depth(frame, c);
  contacts.depth[c] = std::clamp(estimate.depth, 0.0, estimate.deepest) * std::min(1.0, agreement);
  contacts.direction[c] = normalized(estimate.normal);
  contacts.certainty[c] = std::min(1.0, agreement);
  estimate.rough = true;
}

/// Without any plane: depth 0, direction away from the centre of its tet.
void DepthEstimate::set_unknown_depth(const Frame& frame, std::size_t c) {
  Contacts& contacts = frame.table.contacts();
  const Tet& tet = at(frame.bodies.tets(), contacts.tet[c]);
  Vec3 middle;
  for (const Index corner : tet) middle += 0.25 * at(frame.positions, corner);
  const Vec3 direction = normalized(at(frame.positions, contacts.point[c]) - middle);
  contacts.depth[c] = 0.0;
  contacts.direction[c] = direction == Vec3{} ? Vec3{0.0, 0.0, 1.0} : direction;
  contacts.certainty[c] = 0.0;
  estimates_[c].rough = true;
}

/// In self-contact: the point, whose own surface must not be its exit; otherwise -1.
Index DepthEstimate::own_point(const Frame& frame, std::size_t c) {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[c];
  return at(frame.bodies.body_of_point(), point) == contacts.body[c] ? point : -1;
}

Index DepthEstimate::regions_not_reached() {
  Index regions = 0;
  for (std::size_t seed = 0; seed < levels_.size(); ++seed) {
    if (levels_[seed] >= 0) continue;
    ++regions;
    frontier_.assign(1, static_cast<Index>(seed));
    levels_[seed] = 0;
    for (std::size_t next = 0; next < frontier_.size(); ++next) {
      const PlaneSystem::Node& node = at(system_.nodes, frontier_[next]);
      for (Index l = node.begin; l < node.end; ++l) {
        const Index other = at(system_.links, l).node;
        if (std::exchange(at(levels_, other), 0) < 0) frontier_.push_back(other);
      }
    }
  }
  return regions;
}

}  // namespace palpate

#include "contact/rim_falloff.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"
#include "mesh/faces.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Largest motion of a body at rest, relative to the reach; in a step, points at rest move by far less.
constexpr double most_moved = 1.0 / 32.0;
/// Largest change of a contact's direction at rest, as the length of the difference of the unit vectors.
constexpr double max_rotation = 1.0 / 64.0;
/// Safety factor for rounding.
constexpr double slack = 1.125;
/// Steps after which a body counts as at rest.
constexpr int a_while = 4;
/// Positions of all points are compared only if there are more contacts per point than this; with fewer it
/// does not pay.
constexpr double few_contacts = 1.0 / 32.0;

/// Mean over the tets of a body of the smallest height at rest.
double mean_height(const Bodies& bodies, Index body) {
  const Range tets = at(bodies.bodies(), body).tets;
  double sum = 0.0;
  for (Index t = tets.begin; t < tets.end; ++t) {
    const Tet& corners = at(bodies.tets(), t);
    const auto rest = [&](std::size_t i) { return at(bodies.points_rest(), corners[i]); };
    const double six_volumes = dot(cross(rest(1) - rest(0), rest(2) - rest(0)), rest(3) - rest(0));
    double largest = 0.0;  // twice the area of a face
    for (const auto& [i, j, k] : outward_face)
      largest = std::max(largest, length(cross(rest(j) - rest(i), rest(k) - rest(i))));
    if (largest > 0.0) sum += six_volumes / largest;
  }
  return tets.size() > 0 ? sum / tets.size() : 0.0;
}

/// Grows from 0 to 1 between two distances.
double between(double inner, double outer, double distance) {
  return std::max(0.0, distance - inner) / (outer - inner);
}

}  // namespace

double rim_reach(const Bodies& bodies, Index body) {
  return reach_of_an_edge * mesh_statistics(bodies, bodies.points_rest(), body).edge_length.mean;
}

RimFalloff::RimFalloff(const Bodies& bodies)
    : rims_(bodies.bodies().size()),
      rests_(bodies.bodies().size()),
      moved_(bodies.bodies().size(), 0.0),
      recorded_(bodies.points_rest().begin(), bodies.points_rest().end()) {
  for (Index b = 0; b < bodies.body_count(); ++b) {
    Rim& rim = at(rims_, b);
    rim.outer = rim_reach(bodies, b);
    rim.inner = std::min(0.075 * mean_height(bodies, b), 0.5 * rim.outer);
    at(moved_, b) = most_moved * rim.outer;
  }
}

void RimFalloff::begin(const parallel::Threads& threads, const Bodies& bodies,
                       std::span<const Vec3> positions, std::size_t contacts) {
  compares_ = static_cast<double>(contacts) > few_contacts * static_cast<double>(positions.size());
  for (Index b = 0; b < bodies.body_count(); ++b) {
    Rest& rest = at(rests_, b);
    if (compares_) {
      compare(threads, at(bodies.bodies(), b).points, positions, at(moved_, b), rest);
    } else if (rest.steps > 0) {
      rest = {rest.number + 1, 0};  // its motion in between was not observed
    }
  }
}

void RimFalloff::compare(const parallel::Threads& threads, Range points, std::span<const Vec3> positions,
                         double most, Rest& rest) {
  constexpr std::size_t grain = 4096;
  const auto first = static_cast<std::size_t>(points.begin);
  const auto count = static_cast<std::size_t>(points.size());
  assign_with_room(farthest_, parallel::chunk_count(count, grain), 0.0);
  parallel::for_chunks(threads, count, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
    double farthest = 0.0;
    for (std::size_t p = first + begin; p < first + end; ++p)
      farthest = std::max(farthest, squared_length(positions[p] - recorded_[p]));
    farthest_[chunk] = farthest;
  });
  const bool rests = std::ranges::all_of(farthest_, [&](double d) { return d <= most * most; });
  if (rests) {
    ++rest.steps;
    return;
  }
  rest = {rest.number + 1, 0};
  parallel::for_each(threads, count, grain,
                     [&](std::size_t p) { recorded_[first + p] = positions[first + p]; });
}

double RimFalloff::scale(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& x, Index tet,
                         const Vec3& direction, ExitSearch& search) const {
  const Rim& rim = at(rims_, bodies.body_of(at(bodies.tets(), tet)));
  return between(rim.inner, rim.outer,
                 search.distance_to_side(bodies, positions, tet, x, direction, rim.outer));
}

double RimFalloff::fading_scale(const Bodies& bodies, std::span<const Vec3> positions, const Vec3& x,
                                Index tet, const Vec3& direction, double width, ExitSearch& search) const {
  constexpr double band = 0.15;  // of cosines
  const Rim& rim = at(rims_, bodies.body_of(at(bodies.tets(), tet)));
  return between(std::min(rim.inner, 0.5 * width), width,
                 search.distance_to_side(bodies, positions, tet, x, direction, width, band));
}

double RimFalloff::scale(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
                         std::size_t c, ExitSearch& search, RimCache& cache) const {
  const Index point = contacts.point[c];
  const Index body = contacts.body[c];
  const Vec3& direction = contacts.direction[c];
  const Index body_of_point = at(bodies.body_of_point(), point);
  const Rest& of_tet = at(rests_, body);
  const Rest& of_point = at(rests_, body_of_point);
  const bool same = cache.state[c] != RimCache::unknown && cache.tet[c] == contacts.tet[c] &&
                    cache.rest_of_point[c] == of_point.number && cache.rest_of_tet[c] == of_tet.number;
  const bool is_clear = same && cache.state[c] == RimCache::clear;
  if (is_clear && length(direction - cache.direction[c]) <= max_rotation) return 1.0;
  // The motion counts twice: from the cached position to the record, and from the record to the current
  // position.
  const double by_tet = 2.0 * slack * at(moved_, body);
  const double by_point = 2.0 * slack * at(moved_, body_of_point);
  const bool rest =
      compares_ && std::min(of_tet.steps, of_point.steps) >= a_while && by_point <= 2.0 * by_tet;
  if (rest && (!same || is_clear)) {
    const bool clear = search.stays_clear(bodies, positions, contacts.tet[c], at(positions, point), direction,
                                          at(rims_, body).outer + by_tet + by_point, by_tet, max_rotation);
    cache.state[c] = clear ? RimCache::clear : RimCache::near;
    cache.tet[c] = contacts.tet[c];
    cache.rest_of_point[c] = of_point.number;
    cache.rest_of_tet[c] = of_tet.number;
    cache.direction[c] = direction;
    if (clear) return 1.0;
  }
  return scale(bodies, positions, at(positions, point), contacts.tet[c], direction, search);
}

}  // namespace palpate

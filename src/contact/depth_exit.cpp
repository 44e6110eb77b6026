// Makes depth and direction of deep contacts consistent: the last part of DepthEstimate, derived in
// docs/depth.md.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/depth.hpp"
#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Depth of a region, in edges: up to the first value nothing changes, from the second on the correction
/// applies in full.
constexpr double shallow = 0.2;
constexpr double deep = 0.4;
/// Agreement and certainty from which the mean plane has full weight.
constexpr double enough_agreement = 0.2;
constexpr double enough_certainty = 0.7;
/// If the end of the exit along the mean plane is this deep, in lengths of that exit, the mean has weight
/// zero.
constexpr double lost_at = 2.0;
/// Depth of the end of the exit, in lengths of that exit, from which a direction counts as uncertain: the
/// nearest surface may then change discontinuously.
constexpr double uncertain_at = 0.3;
/// Faces up to this multiple of the nearest distance are included, so that the end of the exit moves
/// continuously over edges.
constexpr double tie = 1.6;
/// Bound of the distance to the mean plane of these faces, relative to the nearest distance, since the faces
/// may have any orientation.
constexpr double furthest_plane = 1.5;
/// The mean of faces with different normals may end inside. So the exit is lengthened by this factor times (1
/// - length of the mean normal), up to a fraction of the distance.
constexpr double overshoot_by_spread = 20.0;
constexpr double most_overshoot = 0.3;

/// An exit: from p by `length` towards `target`.
struct DepthExit {
  Vec3 target;
  double length = 0.0;
  double inside =
      0.0;  ///< depth of the end of its straight part; 0: that end is outside, or the walk is lost
};

/// The exit of p, a point in `tet`: first along `straight`, then to the surface. `mean_part`, from 0 to 1,
/// chooses the end: 0 is the nearest surface point, 1 the foot on the mean plane of the faces at a similar
/// distance.
DepthExit find_exit(const Bodies& bodies, std::span<const Vec3> positions, Index tet, const Vec3& p,
                    const Vec3& direction, double straight, double mean_part, Index without,
                    ExitSearch& search) {
  const Vec3 end = p + straight * direction;
  const ExitAhead exit = straight > 0.0 ? exit_ahead(bodies, positions, tet, p, direction, straight)
                                        : ExitAhead{.tet = tet, .distance = 0.0};
  // If rounding led the walk astray, the exit is infinite and is not used.
  if (exit.tet < 0) return {end, std::numeric_limits<double>::infinity(), 0.0};
  if (exit.leaves()) return {end, straight, 0.0};
  const SurfacePoint nearest = search.nearest(bodies, positions, exit.tet, end, without,
                                              std::numeric_limits<double>::infinity(), -1.0);
  const double inside = nearest.distance;
  if (!std::isfinite(inside)) return {end, inside, 0.0};
  if (!(mean_part > 0.0)) return {nearest.position, straight + inside, inside};
  const double reach = (1.0 + (tie - 1.0) * mean_part) * inside;
  double sum = 0.0;
  double offset = 0.0;
  Vec3 normal;
  search.for_each_face(bodies, positions, exit.tet, end, without, reach,
                       [&](Index there, std::size_t opposite, const Vec3& x, double distance) {
                         const double excess = inside / distance - inside / reach;
                         const double weight = excess * excess;
                         if (!std::isfinite(weight)) return;  // the face contains the end
                         const Vec3 n = face_normal(bodies, positions, there, opposite);
                         sum += weight;
                         offset += weight * dot(x - end, n);
                         normal += weight * n;
                       });
  const double agreement = length(normal) / sum;
  if (!(agreement > 0.0) || !(offset > 0.0)) return {nearest.position, straight + inside, inside};
  const double to_plane = std::min(offset / (agreement * sum), furthest_plane * inside);
  const double overshoot = std::min(most_overshoot, overshoot_by_spread * std::max(0.0, 1.0 - agreement));
  return {end + to_plane * normalized(normal), straight + (1.0 + mean_part * overshoot) * inside, inside};
}

}  // namespace

/// Depth in edges of the point.
double DepthEstimate::relative_depth(const Frame& frame, std::size_t c) const {
  return frame.table.contacts().depth[c] / system_.nodes[c].length;
}

bool DepthEstimate::is_deep(const Frame& frame, std::size_t c) const {
  return relative_depth(frame, c) > shallow;
}

/// Finds the largest depth in each connected region of contacts, in edges of the point: shallow contacts may
/// belong to a deep region. Returns false if no contact is deep. O(contacts + links).
bool DepthEstimate::find_deepest(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  if (std::ranges::none_of(used_scratches(), [](const Scratch& scratch) { return scratch.deep; }))
    return false;
  constexpr double unknown = -1.0;
  assign_with_room(deepest_, contacts.size(), unknown);
  make_room(frontier_, contacts.size());
  for (std::size_t seed = 0; seed < contacts.size(); ++seed) {
    if (deepest_[seed] != unknown) continue;
    frontier_.assign(1, static_cast<Index>(seed));
    double deepest = deepest_[seed] = relative_depth(frame, seed);
    for (std::size_t next = 0; next < frontier_.size(); ++next) {
      const Range links = at(frame.links.ranges_of_links(), frontier_[next]);
      for (Index l = links.begin; l < links.end; ++l) {
        const Index other = at(frame.links.links(), l);
        if (at(deepest_, other) != unknown) continue;
        at(deepest_, other) = relative_depth(frame, static_cast<std::size_t>(other));
        deepest = std::max(deepest, at(deepest_, other));
        frontier_.push_back(other);
      }
    }
    for (const Index c : frontier_) at(deepest_, c) = deepest;
  }
  return true;
}

void DepthEstimate::lead_out(const Frame& frame) {
  if (!find_deepest(frame)) return;
  parallel::for_chunks(frame.threads, estimates_.size(), contacts_of_search,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         for (std::size_t c = begin; c < end; ++c) {
                           const double fraction =
                               std::clamp((deepest_[c] - shallow) / (deep - shallow), 0.0, 1.0);
                           if (fraction > 0.0) lead_contact_out(frame, c, fraction, scratches_[chunk].search);
                         }
                       });
}

void DepthEstimate::lead_contact_out(const Frame& frame, std::size_t c, double fraction, ExitSearch& search) {
  Contacts& contacts = frame.table.contacts();
  const Estimate& estimate = estimates_[c];
  if (estimate.rough || estimate.from_surface == no_border) return;
  const Vec3& p = at(frame.positions, contacts.point[c]);
  const Vec3 direction = contacts.direction[c];
  const double mean = estimate.mean * std::min(1.0, estimate.agreement / enough_agreement) *
                      std::min(1.0, estimate.certainty / enough_certainty);
  const auto exit_of = [&](double part) {
    return find_exit(frame.bodies, frame.positions, contacts.tet[c], p, direction, part * mean, part,
                     own_point(frame, c), search);
  };
  DepthExit exit = exit_of(1.0);
  double certainty = 1.0;
  if (exit.inside > 0.0) {
    const double part = mean > 0.0 ? std::max(0.0, 1.0 - exit.inside / (lost_at * mean)) : 0.0;
    certainty = part > 0.0 ? part * std::max(0.0, 1.0 - exit.inside / (uncertain_at * mean)) : 0.0;
    if (part < 1.0) exit = exit_of(part);
  }
  const Vec3 out = normalized(exit.target - p);
  if (!std::isfinite(exit.length) || out == Vec3{})
    return;  // the walk is lost, or the point is on the surface
  contacts.depth[c] += fraction * (exit.length - contacts.depth[c]);
  contacts.direction[c] = normalized((1.0 - fraction) * direction + fraction * out);
  contacts.certainty[c] *= 1.0 - fraction * (1.0 - certainty);
}

}  // namespace palpate

#include "contact/plane_cache.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t cached_grain = 256;
/// A cached plane is not used if the point has moved further than this, relative to an edge of the tet: it
/// may then be beside another part of the surface.
constexpr double furthest_moved = 0.5;
/// Largest ratio by which the thickness of a tet along the direction may change.
constexpr double most_strain = 4.0;
/// Factor by which planes age faster in the region of interest.
constexpr std::size_t interest = 4;

/// The edges from the first corner of a tet.
std::array<Vec3, 3> edges_of(const Tet& tet, std::span<const Vec3> positions) {
  const Vec3& origin = at(positions, tet[0]);
  return {at(positions, tet[1]) - origin, at(positions, tet[2]) - origin, at(positions, tet[3]) - origin};
}

}  // namespace

void PlaneCache::choose_none() {
  sources_.clear();
  spared_ = 0;
}

/// Computes the cached plane at its current position, relative to the point. Returns false if it is no longer
/// valid. The plane's covector keeps its products with the edges of the tet, so the products of the plane
/// with points of the tissue stay the same.
bool PlaneCache::follow(const CachedPlanes& planes, std::size_t row, Index point, const Bodies& bodies,
                        std::span<const Vec3> positions, PenetrationPlane& plane) {
  if (planes.tet[row] < 0) return false;
  const Tet& tet = at(bodies.tets(), planes.tet[row]);
  Vec3 place;
  for (std::size_t i = 0; i < 4; ++i) place += planes.weights[row][i] * at(positions, tet[i]);
  const auto [a, b, c] = edges_of(tet, positions);
  const Vec3 moved = at(positions, point) - place;
  if (!(squared_length(moved) <= furthest_moved * furthest_moved * squared_length(a))) return false;
  const Vec3 bc = cross(b, c);
  const Vec3& on_edges = planes.on_edges[row];
  const Vec3 covector =
      (1.0 / dot(a, bc)) * (on_edges.x * bc + on_edges.y * cross(c, a) + on_edges.z * cross(a, b));
  const double thinner = length(covector);
  if (!(thinner <= most_strain && thinner * most_strain >= 1.0)) return false;
  plane.direction = (1.0 / thinner) * covector;
  plane.depth = std::max(0.0, planes.depth[row] / thinner - dot(plane.direction, moved));
  plane.certainty = planes.certainty[row];
  return std::isfinite(plane.depth);
}

/// Chooses `most` of the contacts without a cached plane, at equal intervals in their order, so that each
/// region has some; they compute their plane. Returns their number.
std::size_t PlaneCache::choose_unknown(std::size_t most, std::size_t unknown) {
  if (most >= unknown) {
    std::ranges::replace(sources_, std::uint8_t{neighbors}, std::uint8_t{compute});
    return unknown;
  }
  // The choice differs from detection to detection.
  std::size_t passed = rounds_ * most % unknown;
  for (std::uint8_t& source : sources_) {
    if (source != neighbors) continue;
    passed += most;
    if (passed < unknown) continue;
    passed -= unknown;
    source = compute;
  }
  return most;
}

/// Chooses the most urgent contacts with a cached plane; they compute their plane.
void PlaneCache::choose_most_urgent(std::size_t most) {
  std::array<std::size_t, CachedPlanes::oldest + 1> count{};
  for (std::size_t c = 0; c < sources_.size(); ++c)
    if (sources_[c] == cached) ++count[urgency_[c]];
  std::size_t least = count.size();
  while (least > 0 && count[least - 1] <= most) most -= count[--least];
  // All with urgency `least` or more, and some with the next lower urgency.
  for (std::size_t c = 0; c < sources_.size(); ++c) {
    if (sources_[c] != cached || urgency_[c] + 1U < least) continue;
    if (urgency_[c] < least && most == 0) continue;
    if (urgency_[c] < least) --most;
    sources_[c] = compute;
  }
}

void PlaneCache::choose(const parallel::Threads& threads, const Bodies& bodies,
                        std::span<const Vec3> positions, const ContactTable& table, const ContactTable& last,
                        std::size_t most, const std::optional<InterestRegion>& region) {
  choose_none();
  ++rounds_;
  const std::size_t n = table.size();
  most = std::min(most, n);
  resize_with_room(planes_, n);
  resize_with_room(sources_, n);
  resize_with_room(urgency_, n);
  const CachedPlanes& cache = last.planes();
  const std::vector<Index>& points = table.contacts().point;
  parallel::for_each(threads, n, cached_grain, [&](std::size_t c) {
    const auto row = static_cast<std::size_t>(table.previous()[c]);
    const bool has_plane = table.previous()[c] >= 0 && row < cache.tet.size() &&
                           follow(cache, row, points[c], bodies, positions, planes_[c]);
    if (!has_plane) planes_[c] = {};
    sources_[c] = has_plane ? cached : neighbors;
    if (!has_plane) return;
    const std::size_t age = cache.age[row];
    const bool of_interest = region && region->contains(at(positions, points[c]));
    urgency_[c] = static_cast<std::uint8_t>(
        std::min<std::size_t>(of_interest ? interest * age : age, CachedPlanes::oldest));
  });
  const auto unknown = static_cast<std::size_t>(std::ranges::count(sources_, std::uint8_t{neighbors}));
  const std::size_t for_known = std::min(most / 4, n - unknown);
  choose_most_urgent(most - choose_unknown(most - for_known, unknown));
  spared_ = n - static_cast<std::size_t>(std::ranges::count(sources_, std::uint8_t{compute}));
}

/// Keeps the plane of the last table, one detection older.
void PlaneCache::keep(const ContactTable& last, ContactTable& table, std::size_t contact) {
  CachedPlanes& planes = table.planes();
  copy_row(last.planes(), static_cast<std::size_t>(table.previous()[contact]), planes, contact);
  if (planes.age[contact] < CachedPlanes::oldest) ++planes.age[contact];
}

void PlaneCache::put(const Bodies& bodies, std::span<const Vec3> positions, ContactTable& table,
                     std::size_t c, Outcome outcome) {
  const Contacts& contacts = table.contacts();
  CachedPlanes& planes = table.planes();
  const auto [a, b, d] = edges_of(at(bodies.tets(), contacts.tet[c]), positions);
  const Vec3& n = contacts.direction[c];
  planes.tet[c] = has_own(outcome) ? contacts.tet[c] : -1;
  planes.age[c] = outcome == Outcome::computed ? std::uint8_t{0} : CachedPlanes::oldest;
  planes.weights[c] = contacts.weights[c];
  planes.depth[c] = contacts.depth[c];
  planes.on_edges[c] = {dot(n, a), dot(n, b), dot(n, d)};
  planes.certainty[c] = contacts.certainty[c];
}

}  // namespace palpate

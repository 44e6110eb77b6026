#include "contact/remembered_planes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 256;
/// Of an edge of the tet: a point that has left its place by more may be beside another part of the surface.
constexpr double furthest = 0.5;
/// How many times as thick or thin, along the direction, a tet may become.
constexpr double most_strain = 4.0;
/// How much sooner planes in the region of interest are found anew.
constexpr std::size_t interest = 4;

/// The edges from the first corner of a tet.
std::array<Vec3, 3> edges_of(const Tet& tet, std::span<const Vec3> positions) {
  const Vec3& origin = at(positions, tet[0]);
  return {at(positions, tet[1]) - origin, at(positions, tet[2]) - origin, at(positions, tet[3]) - origin};
}

}  // namespace

void RememberedPlanes::choose_none() {
  sources_.clear();
  spared_ = 0;
}

/// Both lists are in the same order.
void RememberedPlanes::look_up(const Contacts& contacts) {
  resize_with_room(entry_of_, contacts.size());
  std::size_t e = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto wanted = std::pair(contacts.point[c], contacts.body[c]);
    const auto name = [&] { return std::pair(entries_[e].point, entries_[e].body); };
    while (e < entries_.size() && name() < wanted) ++e;
    entry_of_[c] = e < entries_.size() && name() == wanted ? static_cast<Index>(e) : none;
  }
}

/// Where its plane is now, seen from the point; false: it does not tell any more. Points of the tissue keep
/// their product with the plane's covector, whose products with the edges are those of the direction then.
bool RememberedPlanes::follow(const Entry& entry, const Bodies& bodies, std::span<const Vec3> positions,
                              WayOut& way) {
  if (entry.tet < 0) return false;
  const Tet& tet = at(bodies.tets(), entry.tet);
  Vec3 place;
  for (std::size_t i = 0; i < 4; ++i) place += entry.weights[i] * at(positions, tet[i]);
  const auto [a, b, c] = edges_of(tet, positions);
  const Vec3 moved = at(positions, entry.point) - place;
  if (!(squared_length(moved) <= furthest * furthest * squared_length(a))) return false;
  const Vec3 bc = cross(b, c);
  const Vec3 covector = (1.0 / dot(a, bc)) * (entry.on_edges.x * bc + entry.on_edges.y * cross(c, a) +
                                              entry.on_edges.z * cross(a, b));
  const double thinner = length(covector);
  if (!(thinner <= most_strain && thinner * most_strain >= 1.0)) return false;
  way.direction = (1.0 / thinner) * covector;
  way.depth = std::max(0.0, entry.depth / thinner - dot(way.direction, moved));
  way.certainty = entry.certainty;
  return std::isfinite(way.depth);
}

/// Of the contacts that know of no plane `most` find it anew, at equal distances in their order, so that each
/// region has some. Returns how many do.
std::size_t RememberedPlanes::choose_unknown(std::size_t most, std::size_t unknown) {
  if (most >= unknown) {
    std::ranges::replace(sources_, std::uint8_t{neighbors}, std::uint8_t{anew});
    return unknown;
  }
  // Not always the same ones.
  std::size_t passed = rounds_ * most % unknown;
  for (std::uint8_t& source : sources_) {
    if (source != neighbors) continue;
    passed += most;
    if (passed < unknown) continue;
    passed -= unknown;
    source = anew;
  }
  return most;
}

/// The most urgent of those that remember a plane find it anew.
void RememberedPlanes::choose_most_urgent(std::size_t most) {
  std::array<std::size_t, oldest + 1> count{};
  for (std::size_t c = 0; c < sources_.size(); ++c)
    if (sources_[c] == remembered) ++count[urgency_[c]];
  std::size_t least = count.size();
  while (least > 0 && count[least - 1] <= most) most -= count[--least];
  // All of `least` and more, and some of those just below.
  for (std::size_t c = 0; c < sources_.size(); ++c) {
    if (sources_[c] != remembered || urgency_[c] + 1U < least) continue;
    if (urgency_[c] < least && most == 0) continue;
    if (urgency_[c] < least) --most;
    sources_[c] = anew;
  }
}

void RememberedPlanes::choose(const parallel::Threads& threads, const Bodies& bodies,
                              std::span<const Vec3> positions, const Contacts& contacts, std::size_t most,
                              const std::optional<InterestRegion>& region) {
  choose_none();
  ++rounds_;
  most = std::min(most, contacts.size());
  look_up(contacts);
  resize_with_room(ways_, contacts.size());
  resize_with_room(sources_, contacts.size());
  resize_with_room(urgency_, contacts.size());
  parallel::for_each(threads, contacts.size(), grain, [&](std::size_t c) {
    const Index entry = entry_of_[c];
    const bool knows = entry != none && follow(at(entries_, entry), bodies, positions, ways_[c]);
    if (!knows) ways_[c] = {};
    sources_[c] = knows ? remembered : neighbors;
    if (!knows) return;
    const std::size_t age = at(entries_, entry).age;
    const bool of_interest = region && region->contains(at(positions, contacts.point[c]));
    urgency_[c] =
        static_cast<std::uint8_t>(std::min<std::size_t>(of_interest ? interest * age : age, oldest));
  });
  const auto unknown = static_cast<std::size_t>(std::ranges::count(sources_, std::uint8_t{neighbors}));
  const std::size_t for_known = std::min(most / 4, contacts.size() - unknown);
  choose_most_urgent(most - choose_unknown(most - for_known, unknown));
  spared_ = sources_.size() - static_cast<std::size_t>(std::ranges::count(sources_, std::uint8_t{anew}));
}

RememberedPlanes::Entry RememberedPlanes::older(std::size_t contact) const {
  Entry entry = at(entries_, entry_of_[contact]);
  if (entry.age < oldest) ++entry.age;
  return entry;
}

RememberedPlanes::Entry RememberedPlanes::newest(const Bodies& bodies, std::span<const Vec3> positions,
                                                 const Contacts& contacts, std::size_t c, Outcome outcome) {
  const auto [a, b, d] = edges_of(at(bodies.tets(), contacts.tet[c]), positions);
  const Vec3& n = contacts.direction[c];
  return {.point = contacts.point[c],
          .body = contacts.body[c],
          .tet = has_own(outcome) ? contacts.tet[c] : -1,
          .age = outcome == Outcome::found ? std::uint8_t{0} : oldest,
          .weights = contacts.weights[c],
          .depth = contacts.depth[c],
          .on_edges = {dot(n, a), dot(n, b), dot(n, d)},
          .certainty = contacts.certainty[c]};
}

}  // namespace palpate

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/settings.hpp>

#include "contact/contact_table.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The exit of a contact from the penetrated body: a displacement of `depth` along `direction`.
struct PenetrationPlane {
  double depth = 0.0;
  Vec3 direction;  ///< unit vector
  double certainty = 0.0;
};

/// Decides which contacts of a detection compute their penetration plane and which use the one cached in the
/// last table (CachedPlanes), for a detection that has no time to compute all.
///
/// A cached plane moves with the tet that contained the point when it was computed. The depth changes with
/// the motion of the point relative to the plane. This is exact while tet and surface deform alike and the
/// surface is flat there. It is not used if the point has moved by more than half an edge of that tet, or the
/// thickness of the tet has changed several times. Contacts without a cached plane that are not computed use
/// the planes of their neighbours.
class PlaneCache {
 public:
  /// How a contact got its plane: it was computed; only a propagated one was possible in time; it is the
  /// cached one; or there is none.
  enum class Outcome : std::uint8_t { computed, propagated, cached, none };

  /// Source of the plane of a contact in a detection.
  enum Source : std::uint8_t { compute, cached, neighbors };

  /// Chooses the source of each contact's plane, so that about `most` contacts compute theirs: first contacts
  /// without a cached plane (all of them, or a uniform sample); then the contacts with the oldest planes, at
  /// least a quarter of `most`. In the region of interest planes age four times as fast. O(contacts),
  /// parallel.
  /// \param last  the table with which `table` was matched
  void choose(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              const ContactTable& table, const ContactTable& last, std::size_t most,
              const std::optional<InterestRegion>& region = {});
  /// Lets all contacts compute their plane.
  void choose_none();
  /// (n_contacts) a Source. Empty: all compute their plane.
  [[nodiscard]] std::span<const std::uint8_t> sources() const { return sources_; }
  [[nodiscard]] Source source(std::size_t contact) const {
    return sources_.empty() ? compute : static_cast<Source>(sources_[contact]);
  }
  /// Number of contacts that do not compute their plane.
  [[nodiscard]] std::size_t spared() const { return spared_; }
  /// The cached plane at its current position; null: none.
  [[nodiscard]] const PenetrationPlane* plane(std::size_t contact) const {
    return sources_.empty() || planes_[contact].direction == Vec3{} ? nullptr : &planes_[contact];
  }

  /// Stores the planes of a table after its depths were computed. outcome(contact) returns how each was
  /// obtained. Call after choose() or choose_none() of this detection.
  template <class Outcomes>
  void update(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              ContactTable& table, const ContactTable& last, Outcomes&& outcome) const {
    resize_columns(table.planes(), table.size());
    parallel::for_each(threads, table.size(), 256, [&](std::size_t c) {
      const Outcome now = outcome(c);
      if (!has_own(now) && plane(c) != nullptr) {
        keep(last, table, c);
      } else {
        put(bodies, positions, table, c, now);
      }
    });
  }

 private:
  static bool has_own(Outcome outcome) {
    return outcome == Outcome::computed || outcome == Outcome::propagated;
  }
  static void keep(const ContactTable& last, ContactTable& table, std::size_t contact);
  static void put(const Bodies& bodies, std::span<const Vec3> positions, ContactTable& table,
                  std::size_t contact, Outcome outcome);
  [[nodiscard]] static bool follow(const CachedPlanes& planes, std::size_t row, Index point,
                                   const Bodies& bodies, std::span<const Vec3> positions,
                                   PenetrationPlane& plane);
  std::size_t choose_unknown(std::size_t most, std::size_t unknown);
  void choose_most_urgent(std::size_t most);

  std::vector<PenetrationPlane> planes_;  ///< (n_contacts); a zero direction means none
  std::vector<std::uint8_t> sources_;
  std::vector<std::uint8_t> urgency_;  ///< (n_contacts) urgency of contacts with a cached plane
  std::size_t spared_ = 0;
  std::size_t rounds_ = 0;  ///< number of choices so far
};

}  // namespace palpate

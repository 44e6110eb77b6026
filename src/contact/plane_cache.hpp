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

/// Where a contact leaves the penetrated body: as far as `depth`, along `direction`.
struct PenetrationPlane {
  double depth = 0.0;
  Vec3 direction;  ///< unit vector
  double certainty = 0.0;
};

/// Decides which contacts of a detection compute their penetration plane and which use the one cached in the
/// last table (CachedPlanes), for a detection that has no time to compute all.
///
/// A cached plane moves with the tissue, as the tet that held the point when it was computed turns and
/// deforms. Since then the point has moved towards the plane or away from it. That is exact while
/// the tet and the surface deform alike and the surface there is flat. It is not used where the point has
/// left its place by more than half an edge of that tet, or where the tet has become several times as thick
/// or thin. Contacts without a cached plane that are not computed take what their neighbours have.
class PlaneCache {
 public:
  /// What became of a contact: its plane was computed; there was time for a propagated one only; it is the
  /// cached one; or there is none of its own.
  enum class Outcome : std::uint8_t { computed, propagated, cached, none };

  /// Source of the plane of a contact in a detection.
  enum Source : std::uint8_t { compute, cached, neighbors };

  /// Chooses the source of each contact's plane, so that `most` compute their plane: of those without a
  /// cached plane some, sampled uniformly, or all; of the others the oldest, a quarter of `most` at least. In
  /// the region of interest planes age four times as fast. O(contacts), parallel. \param last  the table that
  /// `table` was matched with
  void choose(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              const ContactTable& table, const ContactTable& last, std::size_t most,
              const std::optional<InterestRegion>& region = {});
  /// All compute it.
  void choose_none();
  /// (n_contacts) a Source. Empty: all compute.
  [[nodiscard]] std::span<const std::uint8_t> sources() const { return sources_; }
  [[nodiscard]] Source source(std::size_t contact) const {
    return sources_.empty() ? compute : static_cast<Source>(sources_[contact]);
  }
  /// That do not compute it.
  [[nodiscard]] std::size_t spared() const { return spared_; }
  /// The cached plane, where it is now; null: there is none.
  [[nodiscard]] const PenetrationPlane* plane(std::size_t contact) const {
    return sources_.empty() || planes_[contact].direction == Vec3{} ? nullptr : &planes_[contact];
  }

  /// Stores the planes of a table after its depths, with their outcome(contact). The choose() of this
  /// detection came before, or choose_none().
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

  std::vector<PenetrationPlane> planes_;  ///< (n_contacts) without direction: none
  std::vector<std::uint8_t> sources_;
  std::vector<std::uint8_t> urgency_;  ///< (n_contacts) of those that have a cached plane
  std::size_t spared_ = 0;
  std::size_t rounds_ = 0;  ///< choices so far
};

}  // namespace palpate

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/settings.hpp>

#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"
#include "room.hpp"

namespace palpate {

/// The way out of a body as a contact sees it.
struct WayOut {
  double depth = 0.0;
  Vec3 direction;  ///< unit vector
  double certainty = 0.0;
};

/// What contacts knew of their way out in earlier detections, for one that has no time to find all of it
/// anew.
///
/// The plane through which a contact leaves goes with the tissue, as the tet that held the point when it was
/// found turns and deforms. Since then the point has come nearer to the plane, or gone further from it. That
/// is exact while the tet and the surface deform alike and the surface there is flat. It is not used where
/// the point has left its place by more than half an edge of that tet, or where the tet has become several
/// times as thick or thin. Contacts that know of no plane take what their neighbours know.
class RememberedPlanes {
 public:
  /// What became of it: its plane was found anew; there was time for a first guess only; it is an earlier
  /// one; or there is none of its own.
  enum class Outcome : std::uint8_t { found, guessed, remembered, none };

  /// What a contact goes by in a detection.
  enum Source : std::uint8_t { anew, remembered, neighbors };

  /// Decides what each contact goes by, so that `most` find their way out anew: of those that know of no
  /// plane some from everywhere, or all; of the others the oldest, a quarter of `most` at least. In the
  /// region of interest planes age four times as fast.
  /// O(contacts), parallel.
  void choose(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              const Contacts& contacts, std::size_t most, const std::optional<InterestRegion>& region = {});
  /// All find it anew.
  void choose_none();
  /// (n_contacts) a Source. Empty: all anew.
  [[nodiscard]] std::span<const std::uint8_t> sources() const { return sources_; }
  [[nodiscard]] Source source(std::size_t contact) const {
    return sources_.empty() ? anew : static_cast<Source>(sources_[contact]);
  }
  /// That do not find it anew.
  [[nodiscard]] std::size_t spared() const { return spared_; }
  /// What it remembers; null: nothing.
  [[nodiscard]] const WayOut* way_out(std::size_t contact) const {
    return sources_.empty() || ways_[contact].direction == Vec3{} ? nullptr : &ways_[contact];
  }

  /// Takes over the contacts of a detection, in canonical order, once their depths are known, and their
  /// outcome(contact).
  template <class Outcomes>
  void remember(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                const Contacts& contacts, Outcomes&& outcome) {
    resize_with_room(next_, contacts.size());
    parallel::for_each(threads, contacts.size(), 256, [&](std::size_t c) {
      const Outcome now = outcome(c);
      next_[c] =
          !has_own(now) && way_out(c) != nullptr ? older(c) : newest(bodies, positions, contacts, c, now);
    });
    std::swap(entries_, next_);
  }

 private:
  struct Entry {
    Index point = -1;
    Index body = -1;
    Index tet = -1;        ///< where the point was; -1: it knew nothing
    std::uint8_t age = 0;  ///< detections since; `oldest` where it was a guess
    std::array<double, 4> weights{};
    double depth = 0.0;
    Vec3 on_edges;  ///< direction times each of the edges from the tet's first corner
    double certainty = 0.0;
  };
  static constexpr std::uint8_t oldest = 255;
  static constexpr Index none = -1;

  static bool has_own(Outcome outcome) { return outcome == Outcome::found || outcome == Outcome::guessed; }
  [[nodiscard]] Entry older(std::size_t contact) const;
  [[nodiscard]] static Entry newest(const Bodies& bodies, std::span<const Vec3> positions,
                                    const Contacts& contacts, std::size_t contact, Outcome outcome);
  void look_up(const Contacts& contacts);
  [[nodiscard]] static bool follow(const Entry& entry, const Bodies& bodies, std::span<const Vec3> positions,
                                   WayOut& way);
  std::size_t choose_unknown(std::size_t most, std::size_t unknown);
  void choose_most_urgent(std::size_t most);

  std::vector<Entry> entries_;  ///< by (point, body)
  std::vector<Entry> next_;
  std::vector<Index> entry_of_;  ///< (n_contacts) index or none
  std::vector<WayOut> ways_;     ///< (n_contacts) without direction: none
  std::vector<std::uint8_t> sources_;
  std::vector<std::uint8_t> urgency_;  ///< (n_contacts) of those that know of a plane
  std::size_t spared_ = 0;
  std::size_t rounds_ = 0;  ///< choices so far
};

}  // namespace palpate

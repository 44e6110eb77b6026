#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

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
/// The plane through which a contact leaves goes with the tissue: it keeps its place in the tet that held the
/// point when it was found, and its normal goes with the edges of that tet. Since then the point has come
/// nearer to the plane, or gone further from it. That is exact while the body moves as a rigid one and its
/// surface there is flat. It is not used where the point has left its place by more than half an edge of that
/// tet. Contacts that know of no plane take what their neighbours know.
class RememberedPlanes {
 public:
  /// What a contact goes by in a detection.
  enum Source : std::uint8_t { anew, remembered, neighbors };

  /// Decides what each contact goes by, so that `most` find their way out anew: of those that know of no
  /// plane some from everywhere, or all and the oldest of the others. O(contacts), parallel.
  void choose(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
              const Contacts& contacts, std::size_t most);
  /// All find it anew.
  void choose_none();
  /// (n_contacts) a Source. Empty: all anew.
  [[nodiscard]] std::span<const std::uint8_t> sources() const { return sources_; }
  [[nodiscard]] Source source(std::size_t contact) const {
    return sources_.empty() ? anew : static_cast<Source>(sources_[contact]);
  }
  /// That do not find it anew.
  [[nodiscard]] std::size_t spared() const { return spared_; }
  /// What it remembers; null: nothing, or it was not asked since all have time.
  [[nodiscard]] const WayOut* way_out(std::size_t contact) const {
    return sources_.empty() || ways_[contact].direction == Vec3{} ? nullptr : &ways_[contact];
  }

  /// Takes over the contacts of a detection, in canonical order, once their depths are known.
  /// `rough(contact)` tells of those that did not find their way out in the end.
  template <class Rough>
  void remember(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                const Contacts& contacts, Rough&& rough) {
    next_.resize(contacts.size());
    parallel::for_each(threads, contacts.size(), 256, [&](std::size_t c) {
      next_[c] =
          rough(c) && way_out(c) != nullptr ? older(c) : newest(bodies, positions, contacts, c, rough(c));
    });
    std::swap(entries_, next_);
  }

 private:
  struct Entry {
    Index point = -1;
    Index body = -1;
    Index tet = -1;        ///< where the point was
    std::uint8_t age = 0;  ///< detections since; `oldest` too where it is what neighbours knew
    std::array<double, 4> weights{};
    double depth = 0.0;
    Vec3 along_edges;  ///< direction as a sum of the edges from the tet's first corner
    double certainty = 0.0;
  };
  static constexpr std::uint8_t oldest = 255;
  static constexpr Index none = -1;

  [[nodiscard]] Entry older(std::size_t contact) const;
  [[nodiscard]] static Entry newest(const Bodies& bodies, std::span<const Vec3> positions,
                                    const Contacts& contacts, std::size_t contact, bool rough);
  void look_up(const Contacts& contacts);
  [[nodiscard]] static bool follow(const Entry& entry, const Bodies& bodies, std::span<const Vec3> positions,
                                   WayOut& way);
  std::size_t choose_unknown(std::size_t most, std::size_t unknown);
  void choose_oldest(std::size_t most);

  std::vector<Entry> entries_;  ///< by (point, body)
  std::vector<Entry> next_;
  std::vector<Index> entry_of_;  ///< (n_contacts) index or none
  std::vector<WayOut> ways_;     ///< (n_contacts) without direction: none
  std::vector<std::uint8_t> sources_;
  std::size_t spared_ = 0;
};

}  // namespace palpate

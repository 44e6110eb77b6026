#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "sim/side_shares.hpp"

namespace palpate {

/// What a contact remembers from step to step; contacts are the same while point and penetrated body are.
struct RememberedContact {
  Index point = -1;
  Index body = -1;
  int seen = 0;              ///< times in a row, this one included
  int lost = 0;              ///< steps since it was last there; 0 while it is
  bool speculative = false;  ///< met within the last step, and not yet there at the end of one
  Vec3 slip;                 ///< how far the friction spring is stretched, m; across the direction
  // Of the last time it was there:
  Vec3 force;                    ///< along the direction, at the start of the step, N
  Vec3 direction;                ///< unit
  Vec3 velocity;                 ///< of the point relative to the tet, at the start of the step, m/s
  double stiffness = 0.0;        ///< N/m
  double chatter_damping = 0.0;  ///< N s/m
  SideNote side;                 ///< saves work only, and so is not kept with a saved state
};

/// The memory of all contacts. A contact that is gone is kept for a while, so that one that comes and goes is
/// recognised. Keeps its room; part of the state that a resumed run needs.
class ContactMemory {
 public:
  /// Steps for which a contact that is gone is remembered.
  static constexpr int longest_absence = 20;

  /// Matches the contacts of a step, sorted by (point, body), with those of the step before. O(contacts).
  void update(const Contacts& contacts);

  /// Takes the last update(), and what was added since, back.
  void undo();

  /// Of a contact of the last update(): `lost` is how many steps it had been away. Until the next add().
  [[nodiscard]] RememberedContact& of_contact(std::size_t contact) { return all_[place_[contact]]; }

  /// Those of `contacts`, sorted by (point, body), that were in no update() or add() of this step: their
  /// places in `contacts`. O(contacts).
  void list_unknown(const Contacts& contacts, std::vector<std::size_t>& unknown) const;
  /// Adds contacts that are not known yet, sorted by (point, body), to those of the last update(), as
  /// speculative ones. One that is not there in the next, and never was, leaves no trace. O(all contacts).
  void add(std::span<const RememberedContact> contacts);

  /// All that is remembered, sorted by (point, body).
  [[nodiscard]] const std::vector<RememberedContact>& all() const { return all_; }
  void set_all(std::vector<RememberedContact> contacts) { all_ = std::move(contacts); }

 private:
  void remember_lost(RememberedContact contact);

  std::vector<RememberedContact> all_;     ///< sorted by (point, body)
  std::vector<RememberedContact> last_;    ///< of the step before
  std::vector<RememberedContact> joined_;  ///< scratch
  std::vector<std::size_t> place_;         ///< in all_, of each contact
};

}  // namespace palpate

#pragma once

#include <cstddef>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// What a contact remembers from step to step; contacts are the same while point and penetrated body are.
struct RememberedContact {
  Index point = -1;
  Index body = -1;
  int seen = 0;  ///< times in a row, this one included
  int lost = 0;  ///< steps since it was last there; 0 while it is
  Vec3 slip;     ///< how far the friction spring is stretched, m; across the direction
  // Of the last time it was there:
  Vec3 force;              ///< along the direction, at the start of the step, N
  Vec3 direction;          ///< unit
  Vec3 velocity;           ///< of the point relative to the tet, at the start of the step, m/s
  double stiffness = 0.0;  ///< N/m
  double lag = 0.0;        ///< damping by stiffness, s
  double calming = 0.0;    ///< damping against chatter, N s/m

  /// Force along the direction at the end of its step of that length, from the velocity there, N.
  [[nodiscard]] double normal(const Vec3& velocity_end, double time_step) const {
    return dot(force, direction) - stiffness * (time_step + lag) * dot(velocity_end, direction);
  }
};

/// The memory of all contacts. A contact that is gone is kept for a while, so that one that comes and goes is
/// recognised. Keeps its room; part of the state that a resumed run needs.
class ContactMemory {
 public:
  /// Steps for which a contact that is gone is remembered.
  static constexpr int longest_absence = 20;

  /// Matches the contacts of a step, sorted by (point, body), with those of the step before. O(contacts).
  void update(const Contacts& contacts);

  /// Of a contact of the last update(): `lost` is how many steps it had been away.
  [[nodiscard]] RememberedContact& of_contact(std::size_t contact) { return all_[place_[contact]]; }

 private:
  void remember_lost(RememberedContact contact);

  std::vector<RememberedContact> all_;  ///< sorted by (point, body)
  std::vector<RememberedContact> last_;
  std::vector<std::size_t> place_;  ///< in all_, of each contact
};

}  // namespace palpate

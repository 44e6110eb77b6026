#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The plane that a contact had its point leave the penetrated body by. It is of the tissue: it turns and
/// deforms with the tet.
struct KeptContact {
  Index point = -1;
  Index body = -1;
  Index tet = -1;
  std::array<double, 4> distances{};  ///< of the tet's points from the plane, positive outside, m
  std::array<double, 4> foot{};       ///< weights of the point's foot on the plane when it was found
  double stiffness = 0.0;             ///< of the contact, N/m
};

/// Where the point of a kept contact is now.
struct NearContact {
  KeptContact kept;
  double gap = 0.0;                 ///< to the plane, >= 0, m
  Vec3 direction;                   ///< unit; out of the penetrated body
  std::array<double, 4> weights{};  ///< of the foot in the tet
};

/// Contacts of the last step, those that it met included, whose points are not in the body at the start of
/// the next, but so near to it that they may be within the step. Most contacts of stiff bodies at rest are
/// such: one step lifts them by less than a micrometre. In the problem from the start, they need not be found
/// again, one layer of a tower after the other, by a solve and a detection each.
///
/// A contact is kept while its gap is no more than its bodies can close in the step as they move and as
/// gravity accelerates them, and while its foot has not slid on by more than a quarter of the tet: beyond a
/// rim there is nothing to touch. What is dropped too early is found again
/// (ContactResponse::add_speculative()).
class KeptContacts {
 public:
  /// A step begins: the contacts given to add() since the last one are the input of near().
  /// O(n log n).
  void begin();
  /// Places for so many contacts more of this step, to be filled at once.
  [[nodiscard]] std::span<KeptContact> add(std::size_t more);
  /// The step failed: those of the step before are the last ones again.
  void undo() { kept_.swap(next_); }

  /// Of the contacts of the last step that are not in `contacts` (sorted by (point, body)) those that may
  /// touch within `time_step`, s; sorted alike. \param fall  what gravity moves in it, m. O(contacts),
  /// parallel. Until the next call.
  [[nodiscard]] std::span<const NearContact> near(const parallel::Threads& threads, const Bodies& bodies,
                                                  const Contacts& contacts, std::span<const Vec3> positions,
                                                  std::span<const Vec3> velocities, double time_step,
                                                  double fall);

  /// What the next step depends on: part of the state that a resumed run needs.
  [[nodiscard]] const std::vector<KeptContact>& all() const { return next_; }
  void set_all(std::vector<KeptContact> contacts) { next_ = std::move(contacts); }

 private:
  std::vector<KeptContact> kept_;  ///< of the last step, sorted by (point, body)
  std::vector<KeptContact> next_;  ///< of this step
  std::vector<NearContact> near_;
};

/// The plane at distance `depth` from a point of the tet along `direction`, at these positions.
/// \param weights  of the point in the tet
[[nodiscard]] KeptContact kept_contact(const Bodies& bodies, Index point, Index body, Index tet,
                                       const std::array<double, 4>& weights, double depth,
                                       const Vec3& direction, double stiffness,
                                       std::span<const Vec3> positions);

}  // namespace palpate

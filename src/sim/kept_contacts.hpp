#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/rim_falloff.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The penetration plane of a contact in the last step. It moves and deforms with the tet.
struct KeptContact {
  Index point = -1;
  Index body = -1;
  Index tet = -1;
  std::array<double, 4> distances{};  ///< distances of the tet's corners from the plane, positive outside, m
  std::array<double, 4>
      foot{};  ///< barycentric weights of the foot of the point on the plane, when the contact was found
  double stiffness = 0.0;  ///< of the contact, N/m
};

/// The current position of a kept contact's point.
struct NearContact {
  KeptContact kept;
  double gap = 0.0;                 ///< to the plane, >= 0, m
  Vec3 direction;                   ///< unit; out of the penetrated body
  std::array<double, 4> weights{};  ///< barycentric weights of the foot in the tet
};

/// Contacts of the last step (including speculative ones) whose points are outside at the start of the next
/// step but may be inside within it. Most contacts of stiff bodies at rest are such: a step lifts them by
/// less than a micrometre. Since they are in the problem from the start, they need not be found again. In a
/// tower, that would take a solve and a detection for each layer.
///
/// A contact is kept while its bodies can close its gap within the step (by their velocity and gravity), and
/// while its foot has not moved by more than a quarter of the tet, or of the mean edge of the point's body:
/// the foot may otherwise be beyond a rim, and the plane of a large tet is not that of the surface far from
/// where it was found. A contact that is dropped too early is found again
/// (ContactResponse::add_speculative()).
class KeptContacts {
 public:
  /// Begins a step: the contacts that were passed to add() since the last begin() become the input of near().
  /// O(n log n).
  void begin();
  /// Adds `more` contacts of this step; the caller fills them at once.
  [[nodiscard]] std::span<KeptContact> add(std::size_t more);
  /// Call after a failed step: restores the contacts of the step before it.
  void undo() { kept_.swap(next_); }

  /// Contacts of the last step that are not in `contacts` (sorted by (point, body)) but may touch within
  /// `time_step`, s; sorted in the same way. Valid until the next call. O(contacts), parallel.
  /// \param fall  distance by which gravity moves a body in a time step, m
  [[nodiscard]] std::span<const NearContact> near(const parallel::Threads& threads, const Bodies& bodies,
                                                  const RimFalloff& rims, const Contacts& contacts,
                                                  std::span<const Vec3> positions,
                                                  std::span<const Vec3> velocities, double time_step,
                                                  double fall);

  /// The contacts that the next step depends on: part of the saved state.
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

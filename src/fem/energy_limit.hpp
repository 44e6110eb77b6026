#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"

namespace palpate::fem {

/// Finds how much energy contacts give to free bodies in a step, and how far rotations must be slowed down.
///
/// Contacts of a body in a rotated frame (BodyRotations) may drive it: they act at the end of the step, on
/// points that have passed the lowest place and rise, and at arms that the step changes. Where the energy of
/// free bodies that touch each other (a group) has grown without a reason, their rotations are to be slowed
/// down so far that it has not. Errors of single steps have both signs, so what contacts took in the last
/// steps may come back. Only of bodies that touch, maybe by others, a body that is not free: without that,
/// their angular momentum stays. Groups are limited only if all that changes their energy is known, but for
/// what contacts do.
class EnergyLimit {
 public:
  explicit EnergyLimit(std::size_t bodies) : works_(bodies), groups_(bodies), losses_(bodies, 0.0) {}

  /// Energy that contacts took from each body in the last steps and may give back (n_bodies), J: the state
  /// between steps.
  [[nodiscard]] const std::vector<double>& losses() const { return losses_; }
  void set_losses(const std::vector<double>& losses) { losses_ = losses; }

  /// Begins a step of a body.
  /// \param energy  elastic and kinetic, at the start, J; empty if not all that changes it is known
  void begin(std::size_t body, std::optional<double> energy);

  // The rest is called at the end of the step, in this order.
  /// Reduces the losses of earlier steps.
  void forget();
  /// A contact between two bodies, or of a body with itself.
  struct Contact {
    std::array<Index, 2> bodies;
    std::array<bool, 2> free;   ///< the body is free
    std::array<Vec3, 2> paths;  ///< displacements of its points in the step, with their coefficients, m
    Vec3 force{};               ///< at the end of the step, N
    Vec3 force_at_start{};      ///< N
  };
  void add(const Contact& contact);
  /// Something changes the energy of a body, and how much is not known.
  void mark_unknown(Index body) { at(works_, body).is_known = false; }
  /// A body has a rotated frame.
  void mark_rotating(Index body) { at(works_, body).rotates = true; }
  /// Finds the groups. Returns whether any is limited. O(n_bodies).
  bool find_groups();
  [[nodiscard]] bool is_limited(std::size_t body) const { return group(body).is_limited(); }
  /// Energy that contacts gave to a body at most, J.
  [[nodiscard]] double given(std::size_t body) const { return works_[body].given; }
  /// Sets the end of the step of a body; only of limited ones.
  /// \param energy    elastic and kinetic, J
  /// \param given     given() and the work of loads, J
  /// \param rotation  kinetic energy of its rotation in a frame, J; 0 without a frame
  void set_end(std::size_t body, double energy, double given, double rotation);
  /// Adds up the groups and updates the losses. O(n_bodies).
  void settle();
  /// Factor for the angular velocity of a body, at most 1.
  [[nodiscard]] double factor(std::size_t body) const;

 private:
  /// What changes the energy of a body in a step.
  struct Work {
    Index group = -1;           ///< a body of the same group; after find_groups(), the first one
    bool is_known = false;      ///< but for contacts
    bool is_supported = false;  ///< touches a body that is not free
    bool rotates = false;       ///< has a frame
    double energy = 0.0;        ///< at the start, J
    double given = 0.0;         ///< by contacts, at most, J
    double gained = 0.0;        ///< without a reason, J
    double rotation = 0.0;      ///< J
  };
  /// Free bodies that touch each other.
  struct Group {
    int bodies = 0;
    bool is_known = true;  ///< of all bodies
    bool is_supported = false;
    bool rotates = false;   ///< a body has a frame
    double gained = 0.0;    ///< beyond what contacts took before, J
    double rotation = 0.0;  ///< J
    [[nodiscard]] bool is_limited() const { return is_known && is_supported && rotates; }
  };
  [[nodiscard]] Index first_of_group(Index body) const;
  [[nodiscard]] const Group& group(std::size_t body) const { return at(groups_, works_[body].group); }

  std::vector<Work> works_;     ///< (n_bodies)
  std::vector<Group> groups_;   ///< (n_bodies) by their first body
  std::vector<double> losses_;  ///< (n_bodies)
};

}  // namespace palpate::fem

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/forces.hpp>
#include <palpate/mesh.hpp>

#include "fem/coupling.hpp"
#include "geometry/vector.hpp"
#include "parallel/parallel.hpp"
#include "sim/response.hpp"

namespace palpate {

/// A contact of the last solve of a step, with its force.
struct ActedContact {
  /// Points of the contact. For a contact of a point: the point inside, then the corners of the penetrated
  /// tet. For a contact of an edge: its ends, then the corners of the triangle that it passes through; or
  /// (SweptResponse) the ends of the edge that it would have passed, and -1.
  std::array<Index, 5> points{};
  std::array<double, 5> coefficients{};  ///< weights, those of the penetrated body negative
  bool of_edge = false;
  double depth = 0.0;  ///< at the start of the step, m
  Vec3 direction{};
  Vec3 force{};  ///< on the point or the edge, N
  ContactStatus status = ContactStatus::open;
  bool speculative = false;

  /// Number of points of the inner body; the others belong to the penetrated body.
  [[nodiscard]] std::size_t own_points() const { return of_edge ? 2 : 1; }
  [[nodiscard]] std::size_t all_points() const { return points.back() < 0 ? 4 : 5; }
  [[nodiscard]] Index body_inside(const Bodies& bodies) const {
    return bodies.body_of_point()[static_cast<std::size_t>(points.front())];
  }
  [[nodiscard]] Index penetrated_body(const Bodies& bodies) const {
    return bodies.body_of_point()[static_cast<std::size_t>(points[own_points()])];
  }
};

/// The position where the force of a contact acts: its point; for an edge, the point where it meets the
/// surface.
[[nodiscard]] Vec3 place_of(const ActedContact& contact, std::span<const Vec3> positions);

/// Ranges of the kinds of couplings in a step.
struct CouplingRanges {
  std::size_t first_tie = 0;
  std::size_t first_contact = 0;
  std::size_t first_speculative = 0;
};

/// Forces of couplings in the last step: the source of all force results of a Simulation. Filled at the end
/// of a step, so that a failed step does not change it. Reuses its memory.
class StepForces {
 public:
  /// \param response  made the contacts' couplings; in its state after the last solve()
  /// \param velocities  mean ones over the step (n_points x 3): fem::end_force()
  ///
  /// O(couplings), parallel.
  void take(const parallel::Threads& threads, std::span<const fem::Coupling> couplings,
            const CouplingRanges& ranges, const ContactResponse& response, double time_step,
            std::span<const Vec3> velocities);

  [[nodiscard]] const std::vector<ActedContact>& contacts() const { return contacts_; }
  [[nodiscard]] const std::vector<Vec3>& ties() const { return ties_; }  ///< N, on the point
  [[nodiscard]] const std::vector<Vec3>& all() const { return all_; }    ///< of all couplings, N
  void set(std::vector<ActedContact> contacts, std::vector<Vec3> ties) {
    contacts_ = std::move(contacts);
    ties_ = std::move(ties);
  }

  /// Adds up the forces of the contacts on each body (n_bodies x 3), N. O(contacts).
  void sum_over_bodies(const Bodies& bodies, std::span<Vec3> sums) const;

 private:
  std::vector<Vec3> all_;
  std::vector<Vec3> ties_;
  std::vector<ActedContact> contacts_;
};

/// The penetrated tet. For an edge: the tet behind its triangle, or a tet at the other edge. -1: no tet has
/// these corners. O(tets at a point).
[[nodiscard]] Index tet_of(const ActedContact& contact, const Bodies& bodies);

/// Converts to the form for users. O(contacts x tets at a point).
[[nodiscard]] ContactForces contact_forces_of(std::span<const ActedContact> contacts, const Bodies& bodies);

}  // namespace palpate

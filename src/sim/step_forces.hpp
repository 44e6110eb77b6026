#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/forces.hpp>
#include <palpate/mesh.hpp>

#include "fem/coupling.hpp"
#include "parallel/parallel.hpp"
#include "sim/response.hpp"

namespace palpate {

/// A contact that a step was solved with, and the force that it had.
struct ActedContact {
  std::array<Index, 5> points{};  ///< the point that is inside, then the corners of the penetrated tet
  std::array<double, 4> weights{};
  double depth = 0.0;  ///< at the start of the step, m
  Vec3 direction{};
  Vec3 force{};  ///< on the point, N
  ContactStatus status = ContactStatus::open;
  bool speculative = false;
};

/// Which couplings of a step are what.
struct CouplingRanges {
  std::size_t first_tie = 0;
  std::size_t first_contact = 0;
  std::size_t first_speculative = 0;
};

/// What couplings did in the last step: what a Simulation tells of forces is made of this. Copied out at the
/// end of a step, so that a step that fails leaves it as it was. Keeps its memory.
class StepForces {
 public:
  /// \param response    that made the contacts' couplings, as the last solve() had them
  /// \param velocities  mean ones over the step (n_points x 3): fem::end_force()
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

/// The penetrated tet. O(tets at a point).
[[nodiscard]] Index tet_of(const ActedContact& contact, const Bodies& bodies);

/// As users get them. O(contacts x tets at a point).
[[nodiscard]] ContactForces contact_forces_of(std::span<const ActedContact> contacts, const Bodies& bodies);

}  // namespace palpate

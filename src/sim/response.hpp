#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/material.hpp>

#include "fem/coupling.hpp"

namespace palpate {

/// Penalty forces of contacts (paper 3: the force on a collided point grows with its penetration depth), with
/// damping, regularised Coulomb friction, and the reaction on the penetrated tet.
///
/// For the relative position u = p - sum_j w_j x_j of a point and the place of the tet where it lies:
///   force      k d r on the point, -w_j k d r on the corners of the tet (so forces and torques add up to
///   zero), stiffness  k r r^T, implicit in the solver, damping    c r r^T + mu k d / max(|v_t|, v_0) (I - r
///   r^T), with the sliding speed |v_t| at the start of the step.
/// c is `damping` times the critical damping 2 sqrt(k m) of the reduced mass m of point and tet.
class ContactResponse {
 public:
  /// \param masses  (n_points), kg
  /// \param moves   (n_points), 1 where a point can move
  ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                  std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                  std::span<const double> masses, std::span<const std::uint8_t> moves);

  /// One coupling for each contact, in their order. O(contacts), parallel.
  void compute(const parallel::Threads& threads, const Bodies& bodies, const Contacts& contacts,
               std::span<const Vec3> velocities, std::vector<fem::Coupling>& couplings) const;

  /// Force per depth between two bodies, N/m: as set, or two springs in series, one for each body that is not
  /// an obstacle, of 2 E h with h the mean edge length. So two equal bodies give E h: about one layer of
  /// tets.
  [[nodiscard]] double stiffness(Index body_a, Index body_b) const;

 private:
  [[nodiscard]] double reduced_mass(Index point, const Tet& tet, const std::array<double, 4>& weights) const;

  ResponseSettings settings_;
  std::vector<double> body_compliance_;  ///< (n_bodies) m/N; 0 for obstacles
  std::span<const double> masses_;
  std::span<const std::uint8_t> moves_;
};

}  // namespace palpate

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
/// Near a side of the penetrated body (a surface that faces another way than r), within a quarter of its mean
/// edge length, k falls linearly to zero: a point that slips over a rim loses its force little by little
/// instead of at once, without which stacks never come to rest. c is `damping` times the critical damping 2
/// sqrt(k m) of the reduced mass m of point and tet.
class ContactResponse {
 public:
  /// \param masses  (n_points), kg
  /// \param moves   (n_points), 1 where a point can move
  ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                  std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                  std::span<const double> masses, std::span<const std::uint8_t> moves);

  /// One coupling for each contact, in their order. `positions` are those that the contacts were found at.
  /// O(contacts), parallel.
  void compute(const parallel::Threads& threads, const Bodies& bodies, const Contacts& contacts,
               std::span<const Vec3> positions, std::span<const Vec3> velocities,
               std::vector<fem::Coupling>& couplings) const;

  /// Force per depth between two bodies, N/m: as set, or two springs in series, one for each body that is not
  /// an obstacle, of 2 E h with h the mean edge length. So two equal bodies give E h: about one layer of
  /// tets.
  [[nodiscard]] double stiffness(Index body_a, Index body_b) const;

 private:
  [[nodiscard]] double reduced_mass(Index point, const Tet& tet, const std::array<double, 4>& weights) const;

  ResponseSettings settings_;
  /// Share of the stiffness that a contact has so near to a side of the body: 0 to 1.
  [[nodiscard]] double side_share(const Bodies& bodies, std::span<const Vec3> positions,
                                  const Contacts& contacts, std::size_t c) const;

  std::vector<double> rim_width_;        ///< (n_bodies) m
  std::vector<double> body_compliance_;  ///< (n_bodies) m/N; 0 for obstacles
  std::span<const double> masses_;
  std::span<const std::uint8_t> moves_;
};

}  // namespace palpate

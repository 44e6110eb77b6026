#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/material.hpp>

#include "fem/coupling.hpp"

namespace palpate {

/// Penalty forces of contacts (paper 3: the force on a collided point grows with its penetration depth), with
/// damping, Coulomb friction, and the reaction on the penetrated tet.
///
/// For the relative position u = p - sum_j w_j x_j of a point and the place of the tet where it lies:
/// - along the direction r: force k d, on the point and by the weights on the tet (so forces and torques add
/// up to zero),
///   stiffness k r r^T, implicit in the solver, damping c r r^T;
/// - across it, where the contact sticks: a spring of the same k that remembers the slip s since the contact
/// began
///   (Cundall & Strack, "A discrete numerical model for granular assemblies", 1979), force -k s, with damping
///   c and a viscosity of half of mu k d / max(|v_t|, v_0), v_0 = friction_speed, which calms contacts that
///   tremble on a rim;
/// - across it, where it slides (the spring would pull more than mu k d before the step ends): mu k d against
/// the sliding,
///   as an implicit viscosity mu k d / max(|v_t|, v_0); s stays at its bound. Below v_0 that is less than
///   Coulomb's force, so contacts at their bound creep. (A constant force there makes light points on stiff
///   springs tremble.)
/// A viscous law alone, however steep, creeps under a steady load: a stack then leans until it falls.
///
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

  /// One coupling for each contact, in their order. `positions` are those that the contacts were found at,
  /// `time_step` is the time since the last call and to the next; slips are kept from call to call.
  /// O(contacts), parallel.
  void compute(const parallel::Threads& threads, const Bodies& bodies, const Contacts& contacts,
               std::span<const Vec3> positions, std::span<const Vec3> velocities, double time_step,
               std::vector<fem::Coupling>& couplings);

  /// Force per depth between two bodies, N/m: as set, or two springs in series, one for each body that is not
  /// an obstacle, of 10 E h with h the mean edge length. So two equal bodies give 5 E h, about five times
  /// what one layer of tets resists: contacts sink in less than the tissue gives way.
  [[nodiscard]] double stiffness(Index body_a, Index body_b) const;

 private:
  /// How far a contact has slipped since it began, m; zero along the direction.
  struct Slip {
    Index point;
    Index body;
    bool known;  ///< the contact was there at the last call
    Vec3 slip;
  };
  void carry_slips(const Contacts& contacts);
  /// Adds friction to a coupling and moves its slip on.
  void add_friction(double k, double depth, double damping, const Vec3& r, const Vec3& velocity,
                    double time_step, Vec3& slip, fem::Coupling& coupling) const;
  [[nodiscard]] double reduced_mass(Index point, const Tet& tet, const std::array<double, 4>& weights) const;

  ResponseSettings settings_;
  /// Share of the stiffness that a contact has so near to a side of the body: 0 to 1.
  [[nodiscard]] double side_share(const Bodies& bodies, std::span<const Vec3> positions,
                                  const Contacts& contacts, std::size_t c) const;

  std::vector<Slip> slips_;  ///< of the contacts, in their order
  std::vector<Slip> last_slips_;
  std::vector<double> body_compliance_;  ///< (n_bodies) m/N; 0 for obstacles
  std::vector<double> rim_width_;        ///< (n_bodies) m
  std::span<const double> masses_;
  std::span<const std::uint8_t> moves_;
};

}  // namespace palpate

#pragma once

#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/forces.hpp>
#include <palpate/material.hpp>

#include "contact/nearest_surface.hpp"
#include "fem/coupling.hpp"
#include "sim/contact_memory.hpp"
#include "sim/side_shares.hpp"

namespace palpate {

/// A contact as the step's last solve had it.
struct ContactOutcome {
  double depth = 0.0;  ///< at the start of the step, m; negative: the gap of a foreseen contact
  Vec3 direction{};
  ContactStatus status = ContactStatus::open;
};

/// Penalty forces of contacts (paper 3: the force on a collided point grows with its penetration depth), with
/// damping, Coulomb friction, and the reaction on the penetrated tet.
///
/// For the relative position u = p - sum_j w_j x_j of a point and the place of the tet where it lies:
/// - along the direction r: force k d, on the point and by the weights on the tet (so forces and torques add
/// up to zero), stiffness k r r^T, implicit in the solver, damping c r r^T; none where it would pull at the
/// end of the step;
/// - across it: a spring of the same k and c that remembers the slip s since the contact began (Cundall &
/// Strack, "A discrete numerical model for granular assemblies", 1979). Where spring and damper would pull
/// more than mu times the force along r they slide: that much, against the motion, and s stays at its bound.
/// So a body below the friction angle stands still, and one above it slides with Coulomb's force at any
/// speed.
///
/// c is `damping` times the larger of the critical damping 2 sqrt(k m) of the reduced mass m of point and
/// tet, and 10 k h. The latter counts where the contact is stiff against the time step h: undamped, the step
/// would push a body that fell d deep out at d / h, as fast as it came, or faster than it came where several
/// pushed. With the default it is pushed out at d / (4 h).
///
/// Whether a contact pushes or has let go, sticks or slides, and its bound, are decided by the velocities at
/// the END of the step. At a given bound the friction is the derivative of a convex function of them
/// (quadratic up to the bound, linear beyond: Huber's), and refine() is one round of iteratively reweighted
/// least squares on it, which lowers it: the spring of a sliding contact is weakened until at the last
/// velocities it pulls just the bound. So is the push a derivative, quadratic or zero: a round of it is
/// Newton's method. Where the solution goes too far, so that rounds would go to and fro, or not far enough,
/// as reweighting does from stick to slide, a line search takes the place on the way from the last iterate
/// through the solution where the sum of these functions and of the system's own is least. Where a round fits
/// the bounds are renewed, and the step is done when they fit too. A steady stick or slide needs one or two
/// rounds.
///
/// A contact that is not there at the start of a step, but is at its end, is foreseen (foresee()): otherwise
/// a body falls into another for one step before anything stops it, and in a pile each body one step longer
/// than the one below it. Without damping, since its spring acts for a part of the step only.
///
/// Depth and direction of a step are those at its start. Where they change faster than the model of the step
/// foresees (two rims against each other, an edge that leaves a face), a light point would chatter. The sign
/// of it is a relative velocity that turns round, or a contact that comes back. To c then comes (force -
/// foreseen force) / speed, the secant of the error, which fades over a hundred steps: a rule without a scale
/// of its own that is silent elsewhere. Across r it stays within mu k d, so that sliding is not braked.
///
/// Near a side of the penetrated body (a surface that faces another way than r), within a quarter of its mean
/// edge length, k falls linearly to zero: a point that slips over a rim loses its force little by little
/// instead of at once, without which stacks never come to rest. It is zero already at 7.5 % of the mean
/// height of tets: in that band normals turn from one face to the other (SurfaceNormals), and a point that a
/// sliding body has just run over, however flat, would push against its motion.
class ContactResponse {
 public:
  /// \param masses  (n_points), kg
  /// \param moves   (n_points), 1 where a point can move
  ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                  std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                  std::span<const double> masses, std::span<const std::uint8_t> moves);

  /// Throws Error on a setting out of range.
  static void check_settings(const ResponseSettings& settings);
  /// Other settings from the next compute() on; they have passed check_settings().
  void change(const ResponseSettings& settings) { settings_ = settings; }

  /// Appends one coupling for each contact, in their order; friction by the velocities at the start of the
  /// step. `positions` are those that the contacts were found at, `time_step` is the time since the last call
  /// and to the next; what contacts remember is kept from call to call. O(contacts), parallel.
  void compute(const parallel::Threads& threads, const Bodies& bodies, const Contacts& contacts,
               std::span<const Vec3> positions, std::span<const Vec3> velocities, double time_step,
               std::vector<fem::Coupling>& couplings);

  /// Compares the forces in the couplings with what the velocities that they led to ask for (n_points x 3, at
  /// the end of the step). Where they are off by more than 1 %, in root mean square (friction: of its
  /// bounds), adapts the couplings and returns true: another solve is needed. O(contacts), parallel.
  [[nodiscard]] bool refine(const parallel::Threads& threads, std::span<const Vec3> velocities_end,
                            std::span<fem::Coupling> couplings);

  /// Compares the contacts where the step leads to (`contacts`, found at `positions_end`) with those that it
  /// knows. Where bodies meet within the step, with more than 5 % of the forces that act (as refine() found
  /// them), appends couplings for what they meet and returns true: another
  /// solve is needed. Such a contact starts the step with a gap; so it stops what comes at where it meets,
  /// and nothing pulls. O(contacts), parallel.
  [[nodiscard]] bool foresee(const parallel::Threads& threads, const Bodies& bodies, const Contacts& contacts,
                             std::span<const Vec3> positions_end, std::span<const Vec3> velocities_end,
                             std::vector<fem::Coupling>& couplings);

  /// Of a contact, in the order of the couplings. O(1).
  [[nodiscard]] ContactOutcome outcome(std::size_t contact) const;

  /// After a step that failed: forgets its compute(), so that what contacts remember is as before.
  void undo() { memory_.undo(); }

  /// What contacts remember between steps: part of the state that a resumed run needs.
  [[nodiscard]] const std::vector<RememberedContact>& remembered() const { return memory_.all(); }
  void set_remembered(std::vector<RememberedContact> contacts) { memory_.set_all(std::move(contacts)); }

  /// Force per depth between two bodies, N/m: as set, or two springs in series, one for each body that is not
  /// an obstacle, of 10 E h with h the mean edge length. So two equal bodies give 5 E h, about five times
  /// what one layer of tets resists: contacts sink in less than the tissue gives way.
  [[nodiscard]] double stiffness(Index body_a, Index body_b) const;

 private:
  /// How a contact pushes and rubs in the step at hand, and what of it its coupling holds.
  struct Law {
    double stiffness = 0.0;  ///< N/m
    double damping = 0.0;    ///< N s/m
    double depth = 0.0;      ///< at the start of the step, m
    Vec3 slip{};             ///< of the friction spring at the start of the step, m
    Vec3 direction{};        ///< of the contact
    double share = 0.0;      ///< of the friction spring and its damper, 0 to 1
    bool pushes = false;     ///< the force along the direction
    double bound = 0.0;      ///< of the friction that `share` was made for, N
    // Of the iterate that the coupling was made at, but for the first of a step:
    Vec3 velocity{};  ///< relative, m/s
    Vec3 force{};     ///< that holds the rest of the system there, N
  };
  /// A contact at the solution that its coupling led to.
  struct Solved {
    Vec3 velocity;        ///< relative, m/s
    Vec3 force;           ///< of the coupling, N
    double normal;        ///< force as it should be: it pushes or is 0, N
    double normal_error;  ///< N
    double spring_error;  ///< N
    double bound_error;   ///< of the friction, N
  };
  struct Foreseen {
    Law law;
    fem::Coupling coupling;
    RememberedContact remembered;
    double force = 0.0;  ///< along the direction, if nothing stops it, N
  };
  template <class F>
  void for_each_searching(const parallel::Threads& threads, std::size_t size, const F& f);
  [[nodiscard]] double normal_force(const Law& law, const Vec3& velocity) const;
  [[nodiscard]] double spring_share(const Law& law, const Vec3& velocity, double bound) const;
  [[nodiscard]] double resistance(const Law& law) const;
  [[nodiscard]] Vec3 spring_force(const Law& law, const Vec3& velocity) const;
  /// The force at a relative velocity at the end of the step, friction by the bound that the law has, N.
  [[nodiscard]] Vec3 force_at(const Law& law, const Vec3& velocity) const;
  [[nodiscard]] double slope(const parallel::Threads& threads, double share);
  [[nodiscard]] double search_line(const parallel::Threads& threads);
  void take_iterate(Law& law, fem::Coupling& coupling) const;
  static void set_share(Law& law, double share, fem::Coupling& coupling);
  static void set_pushes(Law& law, bool pushes, fem::Coupling& coupling);
  /// Law and coupling of an unknown contact at the end of the step, and what is remembered of it.
  void foresee_one(const Bodies& bodies, const Contacts& contacts, std::size_t c,
                   std::span<const Vec3> positions_end, std::span<const Vec3> velocities_end,
                   ExitSearch& search, Foreseen& foreseen) const;
  void compute_one(const Bodies& bodies, const Contacts& contacts, std::size_t c,
                   std::span<const Vec3> positions, std::span<const Vec3> velocities, ExitSearch& search,
                   fem::Coupling& coupling);
  void update_calming(RememberedContact& contact, const Vec3& force, const Vec3& velocity, double most) const;
  [[nodiscard]] double reduced_mass(Index point, const Tet& tet, const std::array<double, 4>& weights) const;

  ResponseSettings settings_;
  ContactMemory memory_;
  double time_step_ = 0.0;
  std::vector<Law> laws_;             ///< of the contacts, in their order
  std::vector<Solved> solved_;        ///< of refine()
  bool has_iterate_ = false;          ///< laws_ have one of this step
  int renewals_ = 0;                  ///< of the bounds of friction since compute() or foresee()
  bool has_guessed_bounds_ = false;   ///< of foreseen contacts, whose normal forces no solve has shown yet
  std::vector<std::size_t> unknown_;  ///< scratch of foresee()
  std::vector<Foreseen> foreseen_;    ///< scratch of foresee()
  std::vector<RememberedContact> added_;  ///< scratch of foresee()
  std::vector<double> partial_;           ///< scratch
  std::vector<ExitSearch> searches_;      ///< of the chunks of contacts
  std::vector<double> body_compliance_;   ///< (n_bodies) m/N; 0 for obstacles
  SideShares sides_;
  std::span<const double> masses_;
  std::span<const std::uint8_t> moves_;
};

}  // namespace palpate

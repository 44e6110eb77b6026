#pragma once

#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/forces.hpp>
#include <palpate/material.hpp>

#include "contact/contact_table.hpp"
#include "contact/nearest_surface.hpp"
#include "contact/rim_falloff.hpp"
#include "fem/contact_law.hpp"
#include "fem/coupling.hpp"
#include "sim/edge_response.hpp"
#include "sim/kept_contacts.hpp"

namespace palpate {

/// A contact after the last solve of a step.
struct ContactOutcome {
  double depth = 0.0;  ///< at the start of the step, m; negative: the gap of a speculative contact
  Vec3 direction{};
  ContactStatus status = ContactStatus::open;
};

/// A law that stops a point or edge from passing through another body within the step (SweptResponse), with
/// its coupling.
struct StopOfPassing {
  fem::ContactLaw law;
  fem::Coupling coupling;
  bool of_edge = false;  ///< true: the coupling is of an edge; false: of a point and a tet
};

/// Lengths of two steps, s.
struct StepTimes {
  double since;  ///< since the call for the step before
  double ahead;  ///< of the step now
};

/// Penalty forces of contacts (paper 3: the force on a collided point grows with its penetration depth), with
/// damping, Coulomb friction, and the reaction on the penetrated tet.
///
/// For the relative position u = p - sum_j w_j x_j of a point and its position in the tet:
/// - Along the direction r: force k d on the point, and its reaction by the weights on the tet, so that
/// forces and torques add up to zero. Stiffness k r r^T and damping c r r^T are implicit in the solver. No
/// force where it would pull at the end of the step.
/// - Across r: a spring of the same k and c with the slip s since the contact began (Cundall & Strack, "A
/// discrete numerical model for granular assemblies", 1979). Its force is bounded by mu times the force along
/// r. At the bound the contact slides and s stays at its limit. So a body below the friction angle stands
/// still, and one above it slides with Coulomb's force at any speed.
///
/// c is `damping` times the larger of 10 k h and the critical damping 2 sqrt(k m), with the reduced mass m of
/// point and tet. 10 k h is larger where the contact is stiff for the time step h. Undamped, such a step
/// would push a body of depth d out at d / h: as fast as it came, or faster where several contacts push. With
/// the default damping it leaves at d / (4 h).
///
/// Contacts that begin deep (bodies overlap at the start, or were moved into each other) begin softly, with
/// all contacts of the two bodies that begin with them: with a stiffness of two reduced masses over h^2,
/// doubled in each step until it is the usual one. With the usual stiffness, contacts of different directions
/// would squeeze stiff bodies in the first step, and this energy would throw them out several times faster
/// than d / (4 h). A contact that a moving body makes does not begin deep, since it is speculative first.
///
/// The velocities at the END of the step decide whether a contact is open, sticks or slides, and its bound
/// (fem::ContactLaw); fem::ContactSolver finds them.
///
/// A contact that exists at the end of a step but not at its start is speculative (add_speculative()).
/// Without these a body falls into another for one step before a force acts, and in a pile each body falls
/// one step longer than the one below. They have no damping, since their spring acts for a part of the step
/// only.
///
/// Depth and direction are those at the start of the step. Where they change faster than predicted (two rims
/// against each other, an edge that leaves a face), a light point would chatter: its relative velocity
/// reverses, or the contact returns. Then the secant of the error, |force - predicted force| / speed, is
/// added to c, and fades over a few hundred steps. This chatter damping has no length or time scale to choose
/// and is zero elsewhere. Across r its force stays within mu k d, so that it does not slow down sliding.
///
/// Near a side of the penetrated body (a surface with another normal than r), within a quarter of its mean
/// edge length, k falls linearly to zero. So a point that slips over a rim loses its force gradually;
/// otherwise stacks never come to rest. k is zero within 7.5 % of the mean height of tets: there normals
/// change from one face to the other (SurfaceNormals), and a point that a sliding body has just passed over
/// would push against the motion.
class ContactResponse {
 public:
  /// \param masses  (n_points), kg
  /// \param moves   (n_points), 1 where a point can move
  ContactResponse(const Bodies& bodies, std::span<const Material> materials,
                  std::span<const std::uint8_t> obstacles, const ResponseSettings& settings,
                  std::span<const double> masses, std::span<const std::uint8_t> moves);

  /// Throws Error on a setting out of range.
  static void check_settings(const ResponseSettings& settings);
  /// Changes the settings from the next compute() on. They must have passed check_settings().
  void change(const ResponseSettings& settings) { settings_ = settings; }

  /// Makes the laws of the contacts, and appends one coupling without a force for each, in their order. Then
  /// those of edge contacts (EdgeResponse). Then, as speculative contacts, those contacts of the last step
  /// that are near (KeptContacts). O(contacts log contacts), parallel.
  /// \param table      contacts at `positions`; its columns hold their states
  /// \param positions  those at the start of the step, unless move_back() is called
  /// \param times      lengths of the steps before and after this call
  /// \param fall       distance by which gravity moves a body in the step, m
  void compute(const parallel::Threads& threads, const Bodies& bodies, ContactTable& table,
               std::span<const Vec3> positions, std::span<const Vec3> velocities, const StepTimes& times,
               double fall, std::vector<fem::Coupling>& couplings);

  /// Compares the contacts at the predicted positions (`table`, found at `positions_end`) with the acting
  /// ones. If the new ones have more than 5 % of the acting normal forces (`acting`: root of their sum of
  /// squares, N), appends their laws and couplings and returns that ratio (infinite if nothing acts): another
  /// solve is needed. Else returns 0. A new contact starts the step with a gap, so it acts only once the gap
  /// is closed. O(contacts), parallel.
  [[nodiscard]] double add_speculative(const parallel::Threads& threads, const Bodies& bodies,
                                       ContactTable& table, std::span<const Vec3> positions_end,
                                       std::span<const Vec3> velocities_end, double acting,
                                       std::vector<fem::Coupling>& couplings);

  /// Call after a compute() at other positions (`places`) than those at the start of the step. Depths of laws
  /// become those at the start, for the directions there: a point that moves from the start to its place gets
  /// the depth that it has there. O(contacts), parallel.
  void move_back(const parallel::Threads& threads, std::span<const Vec3> places,
                 std::span<const Vec3> positions, std::span<const fem::Coupling> couplings);

  /// Friction counts the velocities at the end of the step, but laws have the mean velocities of the step. In
  /// rotated frames these differ: a point of a body that rolls moves along a chord. So the slip of each law
  /// is changed by what `excess` changes of its friction.
  /// \param excess  (n_points x 3) mean velocities minus those at the end, m/s
  ///
  /// O(contacts), parallel.
  void leave_out(const parallel::Threads& threads, std::span<const Vec3> excess,
                 std::span<const fem::Coupling> couplings);

  /// Whether leave_out() was called since the last compute(): again after each change of frames.
  [[nodiscard]] bool leaves_out() const { return !left_out_.empty(); }

  /// Number of laws of the last compute(), without speculative contacts.
  [[nodiscard]] std::size_t present() const { return present_; }
  /// Appends laws and couplings for points and edges that would otherwise pass through a body within the
  /// step. They are no contacts and are not kept for the next step. O(stops).
  void add_stops(std::span<const StopOfPassing> stops, std::vector<fem::Coupling>& couplings);

  /// Changes the gap of a law of add_stops(), m.
  void set_gap(std::size_t contact, double gap) { laws_[contact].depth = -gap; }

  /// Laws of the contacts of the step, in the order of their couplings.
  [[nodiscard]] std::span<const fem::ContactLaw> laws() const { return laws_; }
  [[nodiscard]] double friction() const { return settings_.friction; }

  /// The state of a contact at its relative velocity at the end of the step. O(1).
  /// \param contact  index of its coupling
  [[nodiscard]] ContactOutcome outcome(std::size_t contact, const Vec3& velocity) const;

  /// Turns the forces of edges (docs/edges.md) on from the next compute() on, with the results of detections,
  /// which must outlive their use. Without normals, the default, turns them off.
  void use_edges(const DetectedSurfaces& surfaces) { surfaces_ = surfaces; }
  /// Sets the faces of rigid bodies through which no edge leaves.
  void set_flush_faces(FlushFaces flush) { flush_ = std::move(flush); }
  /// Whether a law's coupling is between an edge and a triangle; otherwise it is between a point and a tet.
  [[nodiscard]] bool is_of_edge(std::size_t contact) const { return of_edge_[contact] != 0; }

  /// Call after a failed step, together with undo_step() of the table.
  void undo() {
    kept_.undo();
    edges_.undo();
  }

  /// Contacts of the last step: part of the saved state.
  [[nodiscard]] const std::vector<KeptContact>& kept() const { return kept_.all(); }
  void set_kept(std::vector<KeptContact> contacts) { kept_.set_all(std::move(contacts)); }
  [[nodiscard]] const std::vector<EdgeEnd>& edge_ends() const { return edges_.ends(); }
  void set_edge_ends(std::vector<EdgeEnd> ends) { edges_.set_ends(std::move(ends)); }

  /// Penalty stiffness between two bodies, N/m. It is the setting if given. Otherwise, each body that is not
  /// an obstacle has a spring of 10 E h, with the mean edge length h, and the two springs are in series. Two
  /// equal bodies give 5 E h, about five times the stiffness of one layer of tets: contacts sink in less than
  /// the tissue deforms.
  [[nodiscard]] double stiffness(Index body_a, Index body_b) const;
  /// Reduced mass of the two sides of a coupling, kg; 0 if no point of it can move.
  [[nodiscard]] double reduced_mass(const fem::Coupling& coupling) const;
  /// Damping of a contact of this stiffness, without chatter damping, N s/m.
  [[nodiscard]] double damping(const fem::Coupling& coupling, double stiffness) const;
  /// The extension of the friction spring, limited so that its force is at the friction bound.
  [[nodiscard]] Vec3 bounded_slip(const Vec3& slip, const fem::ContactLaw& law) const;
  /// State of a contact in a step.
  struct Acted {
    Vec3 force;               ///< the force on the point at the start of the step, along `direction`, N
    Vec3 direction;           ///< unit
    Vec3 velocity;            ///< relative, at the start of the step, m/s
    double stiffness;         ///< N/m
    double damping;           ///< chatter damping, N s/m
    bool comes_back = false;  ///< it has been open since it last acted
  };
  /// Chatter damping of a contact in the next step, N s/m.
  /// \param full  its stiffness before rim falloff
  [[nodiscard]] double chatter_damping(const Acted& last, const Vec3& force, const Vec3& velocity,
                                       double full) const;
  /// Reach of the rim falloff: distance from a side of a body, m.
  [[nodiscard]] double rim_reach(Index body) const { return rims_.reach(body); }

 private:
  struct Speculative {
    fem::ContactLaw law;
    fem::Coupling coupling;
    Vec3 velocity;  ///< of the point relative to the tet, m/s
    KeptContact kept;
    double force = 0.0;  ///< along the direction, at the predicted velocity, N
  };
  static constexpr std::size_t grain = 256;  ///< contacts
  /// Calls f(i, search) for each i < size. No two threads use the same search at once.
  template <class F>
  void for_each_searching(const parallel::Threads& threads, std::size_t size, const F& f) {
    const std::size_t chunks = parallel::chunk_count(size, grain);
    if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
    parallel::for_chunks(threads, size, grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      for (std::size_t i = begin; i < end; ++i) f(i, searches_[chunk]);
    });
  }
  /// A contact at the end of the step that does not act yet.
  [[nodiscard]] Speculative met(const Bodies& bodies, const Contacts& contacts, std::size_t c,
                                std::span<const Vec3> positions_end, std::span<const Vec3> velocities_end,
                                ExitSearch& search) const;
  [[nodiscard]] Speculative speculative(const fem::Coupling& coupling, double depth, const Vec3& direction,
                                        std::span<const Vec3> velocities, const KeptContact& kept) const;
  /// Appends the contacts of the last step whose points are near.
  void append_near(const parallel::Threads& threads, const Bodies& bodies, ContactTable& table,
                   std::span<const Vec3> positions, std::span<const Vec3> velocities, double fall,
                   std::vector<fem::Coupling>& couplings);
  [[nodiscard]] std::span<const EdgeResponse::Row> meet_edges(const parallel::Threads& threads,
                                                              const Bodies& bodies, const ContactTable& table,
                                                              std::span<const Vec3> positions_end,
                                                              std::span<const Vec3> velocities_end);
  void append_edges(std::span<const EdgeResponse::Row> rows, std::vector<fem::Coupling>& couplings);
  void append_speculative(ContactTable& table, std::vector<fem::Coupling>& couplings);
  /// Lists the pairs of bodies with a contact that begins deep.
  void list_deep_pairs(const Bodies& bodies, const ContactTable& table);
  /// Stiffness of a contact in this step, N/m: `usual`, unless it began with a deep one.
  [[nodiscard]] double stiffness_now(ContactStates& states, std::size_t c, double usual,
                                     const fem::Coupling& coupling, const PairOfBodies& pair) const;
  void compute_one(const Bodies& bodies, ContactTable& table, std::size_t c, std::span<const Vec3> positions,
                   std::span<const Vec3> velocities, ExitSearch& search, fem::Coupling& coupling);

  ResponseSettings settings_;
  KeptContacts kept_;
  EdgeResponse edges_;
  DetectedSurfaces surfaces_;  ///< without normals: edges have no forces
  FlushFaces flush_;
  std::size_t present_ = 0;
  double time_step_ = 0.0;      ///< of the step after the last compute(), s
  double since_ = 0.0;          ///< length of the step before it, s
  std::vector<Vec3> left_out_;  ///< what leave_out() has subtracted from the slips of the first laws, m
  std::vector<fem::ContactLaw> laws_;     ///< in the order of the couplings
  std::vector<std::uint8_t> of_edge_;     ///< the same order
  std::vector<double> scales_;            ///< rim falloff of each contact
  std::vector<PairOfBodies> deep_pairs_;  ///< with a contact that begins deep, sorted
  std::vector<std::size_t> idle_;         ///< contacts that do not act yet; scratch of add_speculative()
  std::vector<Speculative> speculative_;  ///< scratch of append_speculative()
  std::vector<ContactTable::Key> keys_;   ///< the same
  std::vector<double> partial_;           ///< scratch
  std::vector<ExitSearch> searches_;      ///< one for each chunk of contacts
  std::vector<double> body_compliance_;   ///< (n_bodies) m/N; 0 for obstacles
  RimFalloff rims_;
  std::span<const double> masses_;
  std::span<const std::uint8_t> moves_;
};

/// The coupling of a point with the position in a tet with these weights, without a force.
[[nodiscard]] fem::Coupling coupling_of(Index point, const Tet& tet, const std::array<double, 4>& w);

}  // namespace palpate

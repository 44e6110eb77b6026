#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/axis_holds.hpp"
#include "fem/block_matrix.hpp"
#include "fem/body_rotations.hpp"
#include "fem/conjugate_gradients.hpp"
#include "fem/contact_solver.hpp"
#include "fem/coupling.hpp"
#include "fem/elements.hpp"
#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// What a Dynamics carries from step to step.
struct DynamicsState {
  std::vector<Vec3> positions;         ///< (n_points x 3), m
  std::vector<Vec3> velocities;        ///< (n_points x 3), m/s; of points that are not free too
  std::vector<Vec3> velocity_changes;  ///< (n_points x 3), m/s: the guess of the next step
  std::vector<SymmetricMatrix3> plastic_strains;
  std::vector<SymmetricMatrix3> viscous_stresses;  ///< ViscousElements::stresses()
  std::vector<double> inversion_clocks;
  int jacobi_iterations = 0;              ///< SolveReport::jacobi_iterations
  int jacobi_iterations_of_contacts = 0;  ///< the same of solves by ContactSolver
  std::vector<Vec3> multigrid_reference;  ///< (n_points x 3), m, or empty: Multigrid::reference()
  int multigrid_stale_iterations = 0;     ///< Multigrid::stale_iterations()
};

/// The contacts of a step.
struct ContactSet {
  std::span<const ContactLaw> laws;
  /// Of the step: linear ones, then from `first` on one for each law, of which points and coefficients count.
  std::span<Coupling> couplings;
  std::size_t first = 0;
  StepFriction friction{};
};

/// Positions and velocities of all points over time: finite elements (elements.hpp), one linear solve a
/// step, and more where hyperelastic tissue deforms far in it.
///
/// A point is free if it is not fixed, is in no obstacle body and has mass. All others go where prescribe()
/// sends them; without it they have velocity zero and keep their position bit for bit. Copies what it needs
/// of the bodies; takes its memory in the constructor (room for couplings grows with them), so that a steady
/// step allocates nothing. The same bits for every thread count.
class Dynamics {
 public:
  using Report = SolveReport;

  /// At rest: positions are those of the bodies at rest, velocities zero.
  ///
  /// \param materials        per body, or per tet; masses and damping of a point are those of its tets
  /// \param fixed_points     per point: 1 where it does not move
  /// \param obstacle_bodies  per body: 1 where no point moves; no elements are evaluated there
  /// Throws Error on a material out of range (naming body and key), arrays of another length than the bodies
  /// have, and a tet too thin for double precision. O(n_tets log).
  Dynamics(const Bodies& bodies, const Materials& materials, std::vector<std::uint8_t> fixed_points,
           std::vector<std::uint8_t> obstacle_bodies, parallel::Threads threads);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  /// Free points do not move along these axes from the next step on (AxisHolds): the couplings of each step
  /// must have those of holds() among them. Once, before the first step.
  void set_fixed_axes(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> axes);
  [[nodiscard]] const AxisHolds& holds() const { return holds_; }

  /// One implicit Euler step of length h with one linearisation of the tissue (Baraff & Witkin, "Large steps
  /// in cloth simulation", SIGGRAPH 1998, eq. 6), then v += dv, x += h v:
  ///   (M + h C + h^2 K' + W) dv = h (f_elastic + f_external + f_couplings - C v - h K' v) - W v,
  /// with C = mass_damping M + stiffness_damping K' (per tet), K' the turned stiffness of Elements at the
  /// start of the step and W = sum_c J_c^T (h D_c + h^2 S_c) J_c the couplings' own part.
  /// Deviation: bodies that rotate so far that straight paths would swell them use a frame for the step that
  /// turns with them (BodyRotations): f_elastic and K' are those of the turned positions x', from which the
  /// part of K' counts, v in the other terms is the rotated velocity, and the rotation adds to x and to v at
  /// the end. Where tissue is viscous (ViscousElements), f_elastic is its force at the end of the step
  /// without a move, and the elastic K' is its stiffness over the step. Full bodies (Elements) are linearised
  /// anew at the end of the step until their forces there are those of the linear system, to `tolerance` of
  /// the solution: Newton's method for implicit Euler (follow_tissue()).
  ///
  /// \param time_step        h > 0, s
  /// \param gravity          m/s^2, on every mass
  /// \param external_forces  (n_points x 3), N, or empty
  /// \param couplings        their points in range; summed in this order
  /// \param tolerance        residual at which the solve stops, relative to the right side or, where that is
  ///                         smaller (at rest), to the impulse of gravity and external forces (SolveGoal); >=
  ///                         0
  /// \param max_iterations   cap, >= 0; where it is reached the report says so and the iterate is used
  /// The solve starts from the last step's dv, where that is zero from free fall. Throws Error, with the
  /// state as it was, on a parameter out of range, and, naming body and tet, where the right side or the
  /// solution is not finite. Tissue that can yield does so at the end, at the positions that the step led to.
  Report step(double time_step, const Vec3& gravity, std::span<const Vec3> external_forces,
              std::span<const Coupling> couplings, double tolerance, int max_iterations);

  /// Moves points that are not free to these positions in the next step, at constant velocity. The points
  /// are not checked; the positions (one for each) are copied.
  void prescribe(std::span<const Index> points, std::span<const Vec3> positions);

  /// The same in three parts, for couplings that depend on the velocities at the end of the step (friction):
  /// begin_step(), then solve() as often as the couplings change, each from the last solution, then
  /// end_step(). Positions, velocities and plastic strains change in end_step() only. The arguments and
  /// errors are those of step().
  void begin_step(double time_step, const Vec3& gravity, std::span<const Vec3> external_forces);
  /// What Preconditioner::automatic has found out in earlier solves is part of the state.
  /// \param goal  its least scales are set to what gravity and external forces alone would make, its
  /// jacobi_iterations to those of the run
  Report solve(std::span<const Coupling> couplings, SolveGoal goal);
  /// Between solve() and end_step(): where bodies turn otherwise than the frames of the step, takes frames
  /// that turn as the solution does and returns true; then another solve() is due. How fast a body turns
  /// hardly depends on its frame: once a step is enough, in practice.
  bool follow_rotations();
  /// Between solve() and end_step(): whether hyperelastic tissue at the end of the step has other forces than
  /// the linear system says; then it is linearised there, or, where its energy is above what the linear
  /// system promises, on the line to there, and another solve() is due. Elements are left as they are at the
  /// end of the step, when it returns false. O(n_elements), nothing without a full body. \param tolerance
  /// bound of what this error can change of the solution, relative, by mass
  bool follow_tissue(double tolerance);
  /// After follow_tissue() has returned true, in place of another solve(): full bodies end the step where
  /// they were linearised, where the energy of the whole is lower than at the start of that line.
  void end_where_linearised();
  /// Activations of the fibres of each material (Materials::all) from the next begin_step() on, 0 to 1.
  void set_activations(std::span<const double> activations);
  /// The same with contacts, whose forces are those of their laws at the end of the step (ContactSolver);
  /// where they hold as at mean_velocities(), to 1 % of the forces, by one linear solve, which is tried where
  /// they are expected to be `steady`. Again in the same step, with more contacts and the same linear
  /// couplings, it continues from the directions that it has. On return the contacts' couplings hold the
  /// forces that acted.
  Report solve(const ContactSet& contacts, SolveGoal goal, bool steady);
  /// Mean velocities over the step as the last solve() has them, before the first the initial guess (n_points
  /// x 3), m/s: the displacements of points in it, over its length. Those at its end are the same but in
  /// bodies that are followed in their turn.
  [[nodiscard]] std::span<const Vec3> mean_velocities() const { return mean_velocities_; }
  /// Between solve() and end_step(): throws Error naming body and tet where mean_velocities() are above
  /// `max_speed`, or where an element has been inverted for `inverted_time` (s; none: no limit) without a
  /// break and still is at the start of this step. The state stays as it is.
  void check_limits(double max_speed, std::optional<double> inverted_time);
  /// Positions at the end of the step as the last solve() has them (n_points x 3), m: those that end_step()
  /// takes.
  [[nodiscard]] std::span<const Vec3> end_positions() const { return end_positions_; }
  void end_step();

  /// Lists the elements that holding_forces() visits. O(n_elements).
  void find_held_elements();
  /// Between the last solve() and end_step(): the force that each point that is not free needs from outside,
  /// couplings apart, so that Newton's law holds there in the discrete form of step(): (n_points x 3), N,
  /// zero at free points but along axes that are held. The loads are those of begin_step(). O(n_points +
  /// elements at such points).
  void holding_forces(const Vec3& gravity, std::span<const Vec3> external_forces,
                      std::span<Vec3> forces) const;

  [[nodiscard]] std::span<const Vec3> positions() const { return positions_; }    ///< (n_points x 3), m
  [[nodiscard]] std::span<const Vec3> velocities() const { return velocities_; }  ///< (n_points x 3), m/s
  /// dv of the last step (n_points x 3), m/s: the guess of the next. Part of the state that a resumed run
  /// needs.
  [[nodiscard]] std::span<const Vec3> velocity_changes() const { return velocity_changes_; }
  /// Plastic strain of each element in its rotated frame, (n_elements), or empty where no material yields;
  /// and an inversion clock of each (n_elements), s: > 0: the length of the steps in a row that it has
  /// started inverted; < 0: the time until it has its whole bulk modulus again (docs/inversion.md); 0:
  /// neither. Part of the state, too.
  [[nodiscard]] std::span<const SymmetricMatrix3> plastic_strains() const {
    return elements_.plastic_strains();
  }
  [[nodiscard]] std::span<const double> inversion_clocks() const { return inversion_clocks_; }
  /// Elements::tet_of_element(): of what these two have values for.
  [[nodiscard]] std::span<const Index> tet_of_element() const { return elements_.tet_of_element(); }
  [[nodiscard]] std::span<const double> point_masses() const {
    return masses_;
  }  ///< (n_points), kg, also of obstacles
  [[nodiscard]] std::span<const std::uint8_t> free_points() const { return free_; }  ///< (n_points) 1: moves
  /// (n_points) axes along which a point is not free: 7 where it is not free at all.
  [[nodiscard]] std::span<const std::uint8_t> held_axes() const { return held_axes_; }
  [[nodiscard]] const parallel::Threads& threads() const { return threads_; }
  [[nodiscard]] const Elements& elements() const { return elements_; }

  /// Set the state (n_points x 3). Positions are taken for every point, also where it does not move;
  /// velocities and their changes are taken at points that move and stay zero elsewhere. Throw Error on
  /// another length or a value that is not finite, with the state as it was.
  void set_positions(std::span<const Vec3> positions);
  void set_velocities(std::span<const Vec3> velocities);
  void set_velocity_changes(std::span<const Vec3> changes);
  /// Velocities of some points that are free along them, finite: checked by the caller. O(points).
  void set_velocities(std::span<const Index> points, std::span<const Vec3> velocities);
  /// The same for values per element, of the lengths of plastic_strains() and inversion_clocks(). A strain
  /// is taken where the material can yield and stays zero elsewhere.
  void set_plastic_strains(std::span<const SymmetricMatrix3> strains);
  void set_inversion_clocks(std::span<const double> clocks);
  /// All of it: steps after set_state(state()) have the bits that they would have had. set_state() throws
  /// Error on another length or a value that is not finite, with the state as it was. O(n_points +
  /// n_elements).
  [[nodiscard]] DynamicsState state() const;
  void set_state(const DynamicsState& state);

  /// Sum of m v^2 / 2 over the free points, J.
  [[nodiscard]] double kinetic_energy();
  /// Elastic energy of all elements at the positions as they are now, J. O(n_elements), rotations included.
  [[nodiscard]] double elastic_energy();
  /// Elements without a positive volume at the positions as they are now. O(n_elements), and rotations unless
  /// elastic_energy() was just asked for.
  [[nodiscard]] std::int64_t inverted_elements();

 private:
  void set_time_step(double time_step);
  void linearise();
  void form_system();
  void place_linear_positions();
  void update_elements();
  void compute_point_forces();
  void add_rotation_forces();
  void add_displacement_forces();
  [[nodiscard]] bool is_full(std::size_t point) const { return full_points_[point] != 0; }
  [[nodiscard]] const Vec3& linear_position(std::size_t point) const;
  [[nodiscard]] double full_energy();
  [[nodiscard]] double tissue_error();
  void shorten_step(double linear_energy, double work, double stiff_work, double promised);
  void set_loads(const Vec3& gravity, std::span<const Vec3> external_forces);
  void compute_free_right_side();
  void compute_right_side();
  void check_right_side();
  void linearise_contacts(const ContactSet& contacts);
  bool solve_linearised(const ContactSet& contacts, const SolveGoal& goal, Report& report);
  [[nodiscard]] double contact_error(const ContactSet& contacts);
  void put_forces(const ContactSet& contacts, bool of_laws);
  void check_solution(double residual);
  void set_base_velocities();
  void mark_held_bodies();
  void find_end();
  void set_initial_guess(double time_step, const Vec3& gravity);
  void advance_inversion_clocks();
  void add_damping_forces(std::span<Vec3> forces) const;
  void add_stiff_forces(std::span<Vec3> forces) const;
  [[nodiscard]] Vec3 stiff_velocity(Index point, double elastic) const;
  void set_bulk_fraction(std::size_t element);
  void check_points(std::span<const Vec3> values, const char* name);
  static void check_tensors(const char* name, std::span<const SymmetricMatrix3> values, std::size_t expected,
                            const char* per);
  void set_moving(std::span<const Vec3> values, const char* name, std::vector<Vec3>& target);
  [[nodiscard]] bool all_finite(std::span<const Vec3> values);
  [[nodiscard]] bool all_finite(std::span<const simd::Padded3> values);
  [[nodiscard]] Error error_at_element(Index element, const std::string& found,
                                       const std::string& expected) const;
  [[nodiscard]] Error error_at_point(std::size_t point, const std::string& found,
                                     const std::string& expected) const;

  parallel::Threads threads_;
  std::vector<Body> bodies_;
  std::vector<Index> body_of_point_;
  std::vector<double> masses_;
  Elements elements_;
  std::vector<std::uint8_t> free_;
  std::vector<std::uint8_t> rigid_;  ///< (n_bodies)
  AxisHolds holds_;
  std::vector<std::uint8_t> held_axes_;    ///< (n_points)
  std::vector<Index> held_elements_;       ///< with a corner that is not free along all axes
  std::vector<std::size_t> held_domains_;  ///< SmoothingDomains, the same
  BlockMatrix matrix_;
  CouplingSystem couplings_;
  LinearSystem system_;
  CouplingSystem stiff_couplings_;  ///< with those of contacts, for preconditioners
  LinearSystem stiff_system_;
  Multigrid multigrid_;
  ConjugateGradients solver_;
  ContactSolver contact_solver_;
  bool goes_on_ = false;                           ///< contact_solver_ has solved this linear system
  std::vector<double> point_mass_damping_;         ///< (n_points), mean of the tets by mass
  std::vector<double> element_stiffness_damping_;  ///< (n_elements)
  std::vector<double> diagonal_;                   ///< (n_points), scratch: mass part of the matrix
  std::vector<double> factors_;                    ///< (n_elements), scratch: stiffness part of the matrix
  std::vector<double> partial_;
  std::vector<Vec3> positions_;
  std::vector<Vec3> end_positions_;                     ///< as the last solve() has them
  std::vector<double> inversion_clocks_;                ///< (n_elements), before the step that has begun
  std::vector<SymmetricMatrix3> plastic_strains_next_;  ///< scratch
  std::vector<Vec3> velocities_;
  std::vector<Vec3> velocity_changes_;
  std::vector<simd::Padded3> solution_;
  std::vector<simd::Padded3> right_side_;
  std::vector<simd::Padded3> free_right_side_;  ///< without couplings
  BodyRotations rotations_;                     ///< of the step that has begun
  std::vector<std::uint8_t> held_bodies_;       ///< 1 where a body is not bent (BodyRotations), but for
  std::vector<std::uint8_t> straight_bodies_;   ///< prescribed points: with them
  bool bent_ = false;                           ///< some body is
  /// What elements are linearised about, where not positions_: bodies as they are turned, full bodies as
  /// follow_tissue() moved them.
  std::vector<Vec3> linear_positions_;
  bool refined_ = false;                      ///< follow_tissue() has moved them in this step
  bool at_end_ = false;                       ///< elements of full bodies are as end_positions_ are
  std::vector<std::uint8_t> full_points_;     ///< (n_points) 1: of a full body
  std::vector<double> elastic_fractions_;     ///< (n_elements) h a / (h a + b): of the stiffness factor
  std::vector<double> damping_fractions_;     ///< (n_elements) the rest
  std::vector<simd::Padded3> displacements_;  ///< (n_points) scratch
  std::vector<Vec3> linear_forces_;           ///< (n_points) elastic, of the linear system at its solution
  std::vector<Vec3> loads_;                   ///< (n_points) gravity and external forces of the step, N
  std::vector<Vec3> point_forces_;            ///< at the start of the step, couplings apart
  std::vector<Vec3> mean_velocities_;         ///< as the last solve() has them
  std::vector<Index> prescribed_points_;      ///< for the next step
  std::vector<Vec3> prescribed_positions_;    ///< of them, at its end
  std::vector<simd::Padded3> rotation_velocities_;  ///< scratch
  std::vector<simd::Padded3> base_velocities_;  ///< at the start of the step; where not free, as prescribed
  double load_impulse_ = 0.0;                   ///< |h (M g + external forces)| over the free points, N s
  double load_scale_ = 0.0;    ///< of the solution, by mass: that of gravity and external forces alone
  double time_step_ = 0.0;     ///< of the step that has begun; that of diagonal_ and factors_
  int jacobi_iterations_ = 0;  ///< of block Jacobi, that a solve has not been enough with
  int jacobi_iterations_of_contacts_ = 0;  ///< the same of contact_solver_: it takes more than a linear solve
  bool updated_ = false;                   ///< elements_ are as the positions and the plastic strains are now
};

}  // namespace palpate::fem

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
#include "fem/energy_limit.hpp"
#include "fem/external_forces.hpp"
#include "fem/linear_system.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// The state of a Dynamics between steps.
struct DynamicsState {
  std::vector<Vec3> positions;         ///< (n_points x 3), m
  std::vector<Vec3> velocities;        ///< (n_points x 3), m/s; also of points that are not free
  std::vector<Vec3> velocity_changes;  ///< (n_points x 3), m/s: the guess of the next step
  std::vector<SymmetricMatrix3> plastic_strains;
  std::vector<SymmetricMatrix3> viscous_stresses;  ///< ViscousElements::stresses()
  std::vector<double> inversion_clocks;
  int jacobi_iterations = 0;              ///< SolveReport::jacobi_iterations
  int jacobi_iterations_of_contacts = 0;  ///< the same of ContactSolver
  double error_per_bound = 0.0;           ///< SolveReport::error_per_bound
  std::vector<Vec3> multigrid_reference;  ///< (n_points x 3), m, or empty: Multigrid::reference()
  int multigrid_stale_iterations = 0;     ///< Multigrid::stale_iterations()
  std::vector<Vec3> past_positions;       ///< (n_points x 3), m, at the start of the previous step; or empty
  std::vector<Vec3> past_velocities;      ///< velocities then, m/s
  double past_duration = 0.0;             ///< length of the previous step, s
  std::vector<double> contact_losses;     ///< (n_bodies) EnergyLimit::losses(), J
  std::vector<Vec3> second_order_multigrid_reference;  ///< as multigrid_reference, for steps of second order
  int second_order_multigrid_stale_iterations = 0;
};

/// The contacts of a step.
struct ContactSet {
  std::span<const ContactLaw> laws;
  /// Couplings of the step: first the linear ones; then, from index `first` on, one for each law, with its
  /// points and coefficients.
  std::span<Coupling> couplings;
  std::size_t first = 0;
  StepFriction friction{};
};

/// Positions and velocities of all points over time: finite elements (elements.hpp), one linear solve a step,
/// and more for large deformations of hyperelastic tissue.
///
/// A point is free if it is not fixed, is in no obstacle and has mass. All other points move as prescribe()
/// says; without that they have velocity zero and keep their position in every bit. Copies the data of the
/// bodies. The constructor allocates memory (that of couplings grows on demand), so a steady step allocates
/// nothing. The bits are the same for every thread count.
class Dynamics {
 public:
  using Report = SolveReport;

  /// The first state: the bodies are at their rest positions, velocities are zero.
  ///
  /// \param materials        per body, or per tet; masses and damping of a point come from its tets
  /// \param fixed_points     per point, 1 if it does not move
  /// \param obstacle_bodies  per body, 1 if it does not move: its elements are not evaluated
  ///
  /// Throws Error on a material out of range (naming body and key), an array of the wrong length, and a tet
  /// too thin for double precision. O(n_tets log).
  Dynamics(const Bodies& bodies, const Materials& materials, std::vector<std::uint8_t> fixed_points,
           std::vector<std::uint8_t> obstacle_bodies, parallel::Threads threads);
  Dynamics(const Dynamics&) = delete;
  Dynamics& operator=(const Dynamics&) = delete;

  /// Holds free points along these axes (AxisHolds). The couplings of each step must then include those of
  /// holds(). Call once, before the first step.
  void set_fixed_axes(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> axes);
  [[nodiscard]] const AxisHolds& holds() const { return holds_; }

  /// One implicit Euler step of length h with one linearisation of the tissue (Baraff & Witkin, "Large steps
  /// in cloth simulation", SIGGRAPH 1998, eq. 6), then v += dv, x += h v:
  ///   (M + h C + h^2 K' + W) dv = h (f_elastic + f_external + f_couplings - C v - h K' v) - W v,
  /// with C = mass_damping M + stiffness_damping K' (per tet), the rotated stiffness K' of Elements at the
  /// start of the step and the couplings' part W = sum_c J_c^T (h D_c + h^2 S_c) J_c. Deviations: Bodies
  /// whose rotation would swell them along straight paths are solved in a frame that rotates with them
  /// (BodyRotations): f_elastic and K' are those at the rotated positions x', K' acts on displacements from
  /// there, v in the other terms is the rotated velocity, and the rotation adds to x and to v at the end. In
  /// viscous tissue (ViscousElements), f_elastic is the force at the end of the step without a motion, and
  /// the elastic K' is the stiffness over the step. Bodies with hyperelastic tets are linearised again at the
  /// end of the step until their forces there equal the forces of the linear system, to `tolerance` of the
  /// solution: Newton's method for implicit Euler (relinearise_tissue()). Their damping is that of the last
  /// linearisation; with passive fibres, of the first (Elements::has_jumps()).
  ///
  /// \param time_step        h > 0, s
  /// \param gravity          m/s^2, on every mass
  /// \param external_forces  (n_points x 3), N, or empty
  /// \param couplings        their points in range; summed in this order
  /// \param tolerance        residual at which the solve stops, >= 0, relative to the larger of the right
  ///                         side and the impulse of gravity and external forces (SolveGoal)
  /// \param max_iterations   cap, >= 0; if it is reached the report says so and the iterate is used
  ///
  /// The solve starts from the last step's dv, or from free fall if that is zero. Throws Error and keeps the
  /// state if a parameter is out of range, or (naming body and tet) the right side or the solution is not
  /// finite. Plastic flow is computed at the end of the step, at the new positions.
  Report step(double time_step, const Vec3& gravity, std::span<const Vec3> external_forces,
              std::span<const Coupling> couplings, double tolerance, int max_iterations);

  /// Moves points that are not free to these positions in the next step, at constant velocity. The points
  /// are not checked; the positions (one for each) are copied.
  void prescribe(std::span<const Index> points, std::span<const Vec3> positions);

  /// Keeps positions and velocities of the previous step, which steps of second order need. Off at first.
  void keep_past(bool on);
  /// Makes the next step BDF2 (Gear's method of second order) instead of implicit Euler:
  ///   M (3 v1 - 4 v0 + v-1) / 2 = h f(x1, v1),  3 x1 - 4 x0 + x-1 = 2 h v1,
  /// which is the step of implicit Euler of length 2 h / 3 from x* = x0 + (x0 - x-1) / 3 and v* = v0 + (v0 -
  /// v-1) / 3. Until end_step() or cancel_step(), positions(), velocities() and step_length() are these, and
  /// couplings are to be made for them. Call it after prescribe(): points that are not free continue at
  /// constant velocity. Returns false, and changes nothing, where no step is before this one (keep_past();
  /// none since positions, velocities or the state were set), where it had another length, and where a body
  /// rotates so fast that its frame would rotate with it (BodyRotations). Tissue must not be viscous.
  /// O(n_points).
  bool start_second_order(double time_step);
  /// Returns to the start of the step after start_second_order(); otherwise does nothing.
  void cancel_step();
  /// Positions at the start of the step: positions(), except after start_second_order().
  [[nodiscard]] std::span<const Vec3> start_positions() const {
    return second_order_ ? start_positions_ : positions_;
  }
  [[nodiscard]] bool is_second_order() const { return second_order_; }
  /// The largest angle by which a body rotates in the step, as a whole, rad; 0 for small ones.
  [[nodiscard]] double largest_rotation() const { return second_order_ ? 0.0 : rotations_.largest_angle(); }
  /// Whether the step is solved in any rotated frame.
  [[nodiscard]] bool has_frames() const { return !second_order_ && rotations_.any(); }
  /// The mean velocities over the step minus those at its end, by the rotations of frames (n_points x 3),
  /// m/s. Valid until the next call. O(n_points).
  [[nodiscard]] std::span<const Vec3> excess_velocities();
  /// Displacement of a point by the frame of its body, m; zero without a frame.
  [[nodiscard]] Vec3 frame_displacement(Index point) const {
    return rotations_.displacement(at(body_of_point_, point), at(positions_, point));
  }
  /// The angle of the frame of a free body, rad; 0 without a frame, and for a body with held or prescribed
  /// points.
  [[nodiscard]] double frame_angle(Index body) const {
    return has_frames() && at(turning_bodies_, body) != 0 ? rotations_.angle(body) : 0.0;
  }
  /// Length of the implicit Euler step that is solved, s: 2/3 of the time step after start_second_order(),
  /// otherwise all of it.
  [[nodiscard]] double step_length(double time_step) const {
    return second_order_ ? 2.0 / 3.0 * time_step : time_step;
  }

  /// Positions at which pressures of the next begin_step() are to be computed (n_points x 3), m: those at the
  /// start of the step, where inner forces have their directions, too. Bodies whose inner forces turn within
  /// the step, as their matrix says, move on for three quarters of the step as without forces, but for the
  /// rotation of their frames. With other positions, pressures have torques and drive vibrations. Valid until
  /// begin_step(). O(n_points).
  [[nodiscard]] std::span<const Vec3> deformed_positions(double time_step);
  /// step() in three parts, for couplings that depend on the velocities at the end of the step (friction):
  /// begin_step(), then solve() after each change of the couplings, from the last solution, then end_step().
  /// Only end_step() changes positions, velocities and plastic strains. Arguments and errors are the same as
  /// for step().
  void begin_step(double time_step, const Vec3& gravity, const ExternalForces& external_forces);
  /// The iteration counts of Preconditioner::automatic in earlier solves are part of the state.
  /// \param goal  its lower bounds are set to the norms for gravity and external forces alone, its
  ///              jacobi_iterations from the state
  Report solve(std::span<const Coupling> couplings, SolveGoal goal);
  /// Call between solve() and end_step(). If the solution rotates bodies otherwise than their frames, updates
  /// the frames and returns true: then solve() again. The frame has little effect on a body's rotation, so
  /// one more solve is usually enough.
  bool update_rotating_frames();
  /// Call between solve() and end_step(). Returns nothing if the forces of hyperelastic tissue at the end of
  /// the step agree with those of the linear system; the elements are then updated there. Otherwise
  /// linearises the tissue there and returns a tolerance: then solve() again with it. While updates are large
  /// it is larger than `tolerance` (inexact Newton: Eisenstat & Walker, SIAM J. Sci. Comput. 17 (1996)).
  /// (If the energy exceeds the prediction of the linear system, the linearisation point is moved back along
  /// the line from the last one.) O(n_elements), nothing without hyperelastic tets.
  /// \param tolerance  largest relative error of the solution, by mass, due to a difference of these forces
  /// \param solved_to  tolerance of the last solve(). If it is larger, the tissue is always linearised again
  std::optional<double> relinearise_tissue(double tolerance, double solved_to = 0.0);
  /// Call after relinearise_tissue() has returned a tolerance, instead of another solve(). Hyperelastic
  /// bodies then end the step at the linearisation point, where the total energy is lower than at the last
  /// one.
  void end_where_linearised();
  /// Activations of the fibres of each material (Materials::all) from the next begin_step() on, 0 to 1.
  void set_activations(std::span<const double> activations);
  /// As solve(), with contacts, whose forces follow their laws at the end of the step (ContactSolver). If the
  /// contacts are expected to keep their status (`steady`), linear solves are tried first; they are enough if
  /// contact forces are right to 1 %. A further call in the same step, with more contacts and the same linear
  /// couplings, reuses the directions. On return the contacts' couplings hold the forces that acted.
  Report solve(const ContactSet& contacts, SolveGoal goal, bool steady);
  /// Mean velocities over the step (n_points x 3), m/s: displacements divided by the time step, by the last
  /// solve(); before it, by the initial guess. They differ from the velocities at the end of the step only in
  /// bodies with a rotated frame or points on arcs.
  [[nodiscard]] std::span<const Vec3> mean_velocities() const { return mean_velocities_; }
  /// Call between solve() and end_step(). Throws Error naming body and tet if mean_velocities() exceed
  /// `max_speed`, or if an element is inverted at the start of this step and has been for `inverted_time`
  /// without interruption (s; empty: no limit). Does not change the state.
  void check_limits(double max_speed, std::optional<double> inverted_time);
  /// Positions at the end of the step by the last solve() (n_points x 3), m. end_step() uses them.
  [[nodiscard]] std::span<const Vec3> end_positions() const { return end_positions_; }
  /// Couplings between bodies (ties and contacts), and their forces over the step (end_force()).
  struct Joints {
    std::span<const Coupling> couplings;
    std::span<const Vec3> forces;
    std::size_t lasting = 0;            ///< the first ones are ties, which act from the start of the step on
    std::span<const Coupling> driving;  ///< others, whose work is not known
  };
  /// Bodies with a rotated frame get the angular momentum that forces of joints lack: they acted at arms in
  /// the rotated bodies, while the momentum of centres counts arms from the start of the step. Without that,
  /// bodies that are tied and rotate together are braked (BodyRotations::allowed_impulse). Contacts do not
  /// drive such bodies (EnergyLimit).
  void end_step(const Joints& joints = {{}, {}, 0, {}});

  /// Lists the elements that holding_forces() visits. O(n_elements).
  void find_constrained_elements();
  /// Call between the last solve() and end_step(). Holding forces, without those of couplings (n_points x 3),
  /// N: at each point that is not free, the external force for which Newton's law holds in the discrete form
  /// of step(). Zero at free points except along held axes. The loads are the loads of begin_step().
  /// O(n_points + elements at such points).
  void holding_forces(const Vec3& gravity, std::span<const Vec3> external_forces,
                      std::span<Vec3> forces) const;

  /// What holding_forces() lack of the last step, whose end_step() was called, in bodies with a rotated frame
  /// (n_points x 3), N; empty if there are none, or find_constrained_elements() was never called.
  [[nodiscard]] std::span<const Vec3> frame_reactions() const { return frame_reactions_; }

  [[nodiscard]] std::span<const Vec3> positions() const { return positions_; }    ///< (n_points x 3), m
  [[nodiscard]] std::span<const Vec3> velocities() const { return velocities_; }  ///< (n_points x 3), m/s
  /// dv of the last step (n_points x 3), m/s: the guess of the next step, and part of the saved state.
  [[nodiscard]] std::span<const Vec3> velocity_changes() const { return velocity_changes_; }
  /// Plastic strain of each element in its rotated frame (n_elements), or empty if no material yields. And
  /// its inversion clock (n_elements), s: > 0: time for which it has been inverted without interruption; < 0:
  /// time until its full bulk modulus is restored (docs/inversion.md); 0: neither. Both are part of the
  /// state.
  [[nodiscard]] std::span<const SymmetricMatrix3> plastic_strains() const {
    return elements_.plastic_strains();
  }
  [[nodiscard]] std::span<const double> inversion_clocks() const { return inversion_clocks_; }
  /// The tet of each element; see Elements::tet_of_element().
  [[nodiscard]] std::span<const Index> tet_of_element() const { return elements_.tet_of_element(); }
  /// The bodies that can have ambient pressures (n_bodies), 1 for each; see Elements.
  [[nodiscard]] std::vector<std::uint8_t> ambient_bodies() const {
    return elements_.ambient_bodies(bodies_.size());
  }
  [[nodiscard]] std::span<const double> point_masses() const {
    return masses_;
  }  ///< (n_points), kg, also of obstacles
  [[nodiscard]] std::span<const std::uint8_t> free_points() const { return free_; }  ///< (n_points) 1: moves
  /// (n_points) axes along which a point is not free; 7: not free at all.
  [[nodiscard]] std::span<const std::uint8_t> held_axes() const { return held_axes_; }
  [[nodiscard]] const parallel::Threads& threads() const { return threads_; }
  [[nodiscard]] const Elements& elements() const { return elements_; }

  /// Set the state (n_points x 3). Positions are set at every point; velocities and their changes at free
  /// points, and stay zero elsewhere. Throw Error and keep the state on a wrong length or a value that is not
  /// finite.
  void set_positions(std::span<const Vec3> positions);
  void set_velocities(std::span<const Vec3> velocities);
  void set_velocity_changes(std::span<const Vec3> changes);
  /// Sets velocities of some points. The caller checks that they are finite and along free axes. O(points).
  void set_velocities(std::span<const Index> points, std::span<const Vec3> velocities);
  /// Sets values per element: plastic strains and inversion clocks. Strains are set where the material can
  /// yield and stay zero elsewhere.
  void set_plastic_strains(std::span<const SymmetricMatrix3> strains);
  void set_inversion_clocks(std::span<const double> clocks);
  /// The whole state: set_state(state()) does not change the bits of later steps. set_state() throws Error
  /// and keeps the state on a wrong length or a value that is not finite. O(n_points + n_elements).
  [[nodiscard]] DynamicsState state() const;
  void set_state(const DynamicsState& state);

  /// Sum of m v^2 / 2 over the free points, J.
  [[nodiscard]] double kinetic_energy();
  /// Elastic energy of all elements at the current positions, J. O(n_elements), with their rotations.
  [[nodiscard]] double elastic_energy();
  /// Number of elements without a positive volume at the current positions. O(n_elements); computes their
  /// rotations unless elastic_energy() was just called.
  [[nodiscard]] std::int64_t inverted_elements();

 private:
  void set_time_step(double time_step);
  void begin_rotations(double time_step);
  void store_past();
  void forget_past();
  [[nodiscard]] Multigrid& multigrid() { return second_order_ ? second_order_multigrid_ : multigrid_; }
  void linearise();
  void form_system();
  void place_linear_positions();
  void update_elements();
  void compute_point_forces();
  void add_rotation_forces();
  void find_lost_impulses(const Joints& joints);
  [[nodiscard]] Vec3 impulse_by_deformation(Index body) const;
  void add_lost_impulses();
  [[nodiscard]] bool has_energy_of_domains() const;
  [[nodiscard]] double energy_of_element(Index element) const;
  [[nodiscard]] double energy_of_body(std::size_t body) const;
  [[nodiscard]] bool has_known_energy(std::size_t body) const;
  void begin_energies();
  void add_energy(const Coupling& contact, const Vec3& force);
  void limit_energies(const Joints& joints);
  void end_energy(std::size_t body);
  void slow_down(std::size_t body, double factor);
  void find_frame_reactions();
  void add_joint_impulse(const Coupling& joint, const Vec3& force, bool lasts);
  [[nodiscard]] Vec3 frame_force(std::size_t point) const;
  /// Least scale of the solution in a solve with this tolerance, by mass.
  [[nodiscard]] double least_scale(double tolerance) const {
    return tolerance > 0.0 ? std::max(error_scale_, rounding_ / tolerance) : error_scale_;
  }
  void add_damping_of_rotation();
  void remove_damping_torque();
  void add_displacement_forces();
  [[nodiscard]] bool is_nonlinear(std::size_t point) const { return nonlinear_points_[point] != 0; }
  [[nodiscard]] std::span<const Vec3> linear_positions() const;
  [[nodiscard]] double nonlinear_energy();
  [[nodiscard]] bool inverts_tissue();
  [[nodiscard]] double tissue_error();
  [[nodiscard]] double tissue_scale();
  [[nodiscard]] double product_by_mass(std::span<const simd::Padded3> a, std::span<const simd::Padded3> b);
  /// How fast Newton's method over the tissue converges in a step.
  struct TissueUpdates {
    int count = 0;
    int plain = 0;        ///< since an extrapolation
    double square = 0.0;  ///< of the last one, by mass
    double size = 0.0;    ///< of the last one, relative to the solution
    /// Ratios of the last sizes. The first update is the motion of the step and is left out.
    double ratio = 1.0;
    double ratio_before = 1.0;
    void add(double square, double size);
    [[nodiscard]] double error() const;
    [[nodiscard]] double next_tolerance() const;

   private:
    [[nodiscard]] double slowest() const;
  };
  /// The tissue as the linear system of an update has it, J.
  struct LinearTissue {
    double energy = 0.0;              ///< at the start of the update
    double work = 0.0;                ///< of the forces at the start
    double stiff_work = 0.0;          ///< of the stiffness
    double predicted_decrease = 0.0;  ///< of the total energy
    /// Energy after a fraction of the update.
    [[nodiscard]] double energy_at(double fraction) const {
      return energy - fraction * work + 0.5 * fraction * fraction * stiff_work;
    }
  };
  bool extrapolate(const LinearTissue& tissue, double ratio);
  void backtrack(const LinearTissue& tissue);
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
  void turn_solution();
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
  std::vector<std::uint8_t> held_axes_;      ///< (n_points)
  std::vector<Index> constrained_elements_;  ///< elements with a corner that is not free along all axes
  std::vector<std::size_t> held_domains_;    ///< smoothing domains with such a corner
  BlockMatrix matrix_;
  CouplingSystem couplings_;
  LinearSystem system_;
  CouplingSystem stiff_couplings_;  ///< couplings with linearised contacts, for preconditioners
  LinearSystem stiff_system_;
  Multigrid multigrid_;
  Multigrid second_order_multigrid_;  ///< hierarchy of the system with the shorter time step of BDF2
  ConjugateGradients solver_;
  ContactSolver contact_solver_;
  bool reuses_directions_ = false;                 ///< contact_solver_ has directions of this linear system
  bool has_linear_couplings_ = false;              ///< that system has couplings
  std::vector<double> point_mass_damping_;         ///< (n_points), mean over its tets, by mass
  std::vector<double> element_stiffness_damping_;  ///< (n_elements)
  std::vector<double> diagonal_;                   ///< (n_points), scratch: mass part of the matrix
  std::vector<double> factors_;                    ///< (n_elements), scratch: stiffness part of the matrix
  std::vector<double> partial_;
  std::vector<Vec3> positions_;
  std::vector<Vec3> end_positions_;                     ///< end of the step by the last solve()
  std::vector<double> inversion_clocks_;                ///< (n_elements), at the start of the step
  std::vector<SymmetricMatrix3> plastic_strains_next_;  ///< scratch
  std::vector<Vec3> velocities_;
  std::vector<Vec3> velocity_changes_;
  std::vector<simd::Padded3> solution_;
  std::vector<simd::Padded3> right_side_;
  std::vector<simd::Padded3> free_right_side_;  ///< without couplings
  BodyRotations rotations_;                     ///< of the step that has begun
  std::vector<std::uint8_t>
      held_bodies_;  ///< 1: no arcs (BodyRotations), because a point is held or the body is nonlinear
  std::vector<std::uint8_t> straight_bodies_;  ///< held_bodies_, and bodies with prescribed points
  bool has_arcs_ = false;                      ///< points of some body move along arcs (BodyRotations)
  /// Positions at which tissue is linearised, where they differ from positions_: bodies in rotated frames,
  /// steps of second order, and hyperelastic bodies after relinearise_tissue().
  std::vector<Vec3> linear_positions_;
  bool refined_ = false;  ///< relinearise_tissue() has set them in this step
  bool at_end_ = false;   ///< hyperelastic elements are updated at end_positions_
  TissueUpdates updates_;
  std::vector<simd::Padded3> last_update_;  ///< displacements
  /// (n_bodies) 1: its matrix has the derivative of its forces by rotations (hyperelastic or smoothed tets)
  std::vector<std::uint8_t> braked_bodies_;
  std::vector<Vec3> excess_velocities_;       ///< scratch of excess_velocities()
  std::vector<std::uint8_t> free_bodies_;     ///< (n_bodies) 1: no point is held; 2: and braked
  std::vector<std::uint8_t> turning_bodies_;  ///< free_bodies_ without prescribed points in this step
  bool has_stiffness_damping_ = false;
  std::vector<Vec3> damping_changes_;           ///< (n_points) scratch of remove_damping_torque(), m/s
  std::vector<double> nonlinear_stiffness_;     ///< (n_points) of a point at rest, by nonlinear tets, N/m
  std::span<const Vec3> turning_forces_;        ///< ExternalForces::turning of the step
  std::vector<Vec3> lost_impulses_;             ///< (n_bodies) scratch of end_step(), N m s
  std::vector<Vec3> contact_impulses_;          ///< (n_bodies) those of contacts
  EnergyLimit energy_limit_;                    ///< what contacts give to free bodies
  Rows elements_of_body_;                       ///< (n_bodies)
  std::vector<Vec3> frame_reactions_;           ///< (n_points) of the last step, N; or empty
  bool lists_constrained_ = false;              ///< find_constrained_elements() was called
  std::vector<std::uint8_t> nonlinear_points_;  ///< (n_points) 1: of such a body
  std::vector<double> elastic_fractions_;       ///< (n_elements), scratch: h a / (h a + b) of the factors
  std::vector<simd::Padded3> displacements_;    ///< (n_points) scratch
  std::vector<Vec3>
      linear_forces_;        ///< (n_points) elastic forces that the linear system predicts at its solution
  std::vector<Vec3> loads_;  ///< (n_points) gravity and external forces of the step, N
  std::vector<Vec3> point_forces_;          ///< (n_points) at the start of the step, without couplings, N
  std::vector<Vec3> mean_velocities_;       ///< by the last solve()
  std::vector<Index> prescribed_points_;    ///< for the next step
  std::vector<Vec3> prescribed_positions_;  ///< at the end of the next step
  std::vector<simd::Padded3> rotation_velocities_;  ///< scratch
  std::vector<simd::Padded3> base_velocities_;  ///< velocities to which the solution is added; the prescribed
                                                ///< ones where points are not free
  double load_impulse_ = 0.0;                   ///< |h (M g + external forces)| over the free points, N s
  double load_scale_ = 0.0;                     ///< mass norm of dv for gravity and external forces alone
  double rounding_ = 0.0;  ///< mass norm of dv by rounding errors of positions: a smaller error is none
  double tissue_rounding_ = 0.0;  ///< the same for the forces of hyperelastic tissue
  double error_scale_ = 0.0;      ///< least mass norm of dv to which errors are relative
  double edge_by_mass_ = 0.0;     ///< mass norm of a motion of all points by a mean edge
  double time_step_ = 0.0;        ///< of the current step; belongs to diagonal_ and factors_
  double duration_ = 0.0;         ///< of the current time step; with BDF2, time_step_ is 2/3 of it
  bool keeps_past_ = false;
  double past_duration_ = 0.0;         ///< length of the previous step, s
  std::vector<Vec3> past_positions_;   ///< positions at the start of the previous step; or empty
  std::vector<Vec3> past_velocities_;  ///< the same
  bool second_order_ = false;          ///< start_second_order()
  std::vector<Vec3> start_positions_;  ///< positions at the start of a step of second order
  std::vector<Vec3> start_velocities_;
  int jacobi_iterations_ = 0;              ///< of block Jacobi, which did not suffice
  int jacobi_iterations_of_contacts_ = 0;  ///< the same of contact_solver_, which needs more
  double error_per_bound_ = 0.0;           ///< of contact_solver_
  bool updated_ = false;  ///< elements_ are updated at the current positions and plastic strains
};

}  // namespace palpate::fem

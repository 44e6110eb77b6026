#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/forces.hpp>
#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/model.hpp>
#include <palpate/settings.hpp>
#include <palpate/tissue.hpp>

namespace palpate {

/// What one step did. Counts and energies are the same on every run; times are of this one.
struct StepMetrics {
  std::int64_t step = 0;      ///< steps done; 0 is the start
  double time = 0.0;          ///< s, of the simulation
  DetectionCounts detection;  ///< at the end of the step
  /// Solves of the step's system; more than one where bodies meet within the step, or rotate fast.
  int solves = 0;
  int detections = 0;                     ///< more than one where bodies met within the step
  std::int64_t speculative_contacts = 0;  ///< contacts of the step that were found within it
  /// Of these, what would have passed through another body and ended on the wrong side (docs/continuous.md).
  std::int64_t stopped_passes = 0;
  /// Left on the wrong side, since the cap of solves was reached or nothing held them; only with
  /// detection.continuous.
  std::int64_t passes = 0;
  /// Pairs of bodies that could meet and of which parts moved so far against each other that they could pass
  /// through.
  std::int64_t pairs_that_could_pass = 0;
  double thinnest = 0.0;         ///< m, least local thickness of these parts; 0: there are none
  bool looks_ahead = true;       ///< false: the budget left no time to search for speculative contacts
  int solver_iterations = 0;     ///< of all solves
  bool solver_converged = true;  ///< each solve
  double kinetic_energy = 0.0;   ///< J
  double elastic_energy = 0.0;   ///< J
  double largest_speed = 0.0;    ///< m/s, over all points
  double fastest_body = 0.0;     ///< m/s, largest root mean square speed (by mass) of a body
  /// m, largest penetration depth: of points, and of edges where two bodies meet by edges alone. Elsewhere
  /// edges of uneven faces are deeper than the points that hold them.
  double deepest = 0.0;
  std::int64_t inverted_tets = 0;    ///< tets of bodies that deform without a positive volume, at the end
  DetectionTimes detection_seconds;  ///< of all detections
  double forces_seconds = 0.0;       ///< contact forces
  double solver_seconds = 0.0;       ///< elastic forces, assembly and linear solve
};

/// Soft bodies under gravity, with contact: the step of positions -> contacts -> forces -> implicit Euler.
///
/// After each step the contacts are those of the positions that it led to. The same input gives the same bits
/// for every structure, order, sort and thread count.
class Simulation {
 public:
  /// \param model    what moves; prescribed points start where their motion is at time 0
  /// \param threads  number of threads; 0 takes all
  /// Throws Error on a setting, material, motion, force, grab or tie out of range, and on arrays of another
  /// length than the bodies have.
  Simulation(Model model, const SimulationSettings& settings, int threads = 0);
  ~Simulation();
  /// A moved-from simulation can only be assigned to or destroyed.
  Simulation(Simulation&&) noexcept;
  /// Frees what this simulation had; the other can only be assigned to or destroyed then.
  Simulation& operator=(Simulation&&) noexcept;

  /// Advances by one time step. Throws Error where the run blows up (a value that is not finite, or beyond
  /// settings().limits), naming body, tet and step: source "body NAME", where "tet T, step N". Then all
  /// results (positions, velocities, contacts, metrics, forces) are those of the last good step.
  const StepMetrics& step();

  /// Other settings from the next step on; positions, velocities, grabs and the state of contacts stay.
  /// Other detection settings find the contacts at positions() anew. Throws Error, and changes nothing, on a
  /// setting that the constructor would refuse and on another time step: steps are counted in it. O(1), and a
  /// detection with its preparation where detection settings differ.
  void change(const SimulationSettings& settings);
  /// Other constraints, motions, ties and loads from the next step on: released points keep the velocity
  /// that they have, fixed or removed ones stand still. Positions stay, except those of
  /// prescribed bodies that come back; the contacts are those without absent bodies at once. Spans and
  /// references that this class has given are invalid, but for bodies(). Throws Error, and changes nothing,
  /// on an index out of range, a point of a rigid body that is to be released by itself, and what the
  /// constructor would refuse. What yielded in a body that is removed is as it was made when it comes back.
  /// O(points + tets log) and a detection with its preparation, as the constructor.
  void change(const ModelChange& change);
  /// Whether a body is there: Model::absent, ModelChange. Throws Error on a body out of range.
  [[nodiscard]] bool is_present(Index body) const;
  /// The ties that there are now.
  [[nodiscard]] std::vector<Tie> ties() const;
  /// (n_points) the motion that each point follows now, or -1.
  [[nodiscard]] std::span<const Index> motion_of_points() const;
  /// Number of motions: those of the model and those that a ModelChange added.
  [[nodiscard]] Index motion_count() const;
  /// Another motion in place of a motion of the model: points on it are where it has them at the end of the
  /// next step, wherever they were. Throws Error, and changes nothing, on a number out of range and on a
  /// motion that the constructor would refuse. O(keyframes).
  void set_motion(Index number, Motion motion);
  /// Points on a motion of the model are at this pose at the end of the next step, at constant speed, and
  /// stay there: a motion of this one keyframe about the same center. Its time does not count. Throws Error,
  /// and changes nothing, as set_motion() does. O(1).
  void move_to(Index number, const Keyframe& pose);
  /// The motion that a number of the model's motions has now. Throws Error on a number out of range.
  [[nodiscard]] const Motion& motion(Index number) const;
  /// Loads a point with a force (N) from the next step on, in place of the one before; zero takes it off.
  /// Throws Error on a point out of range and a force that is not finite.
  void set_force(Index point, const Vec3& force);
  /// The same for many points: forces[i] on points[i]; of a point that is named twice the last counts. Throws
  /// Error, and changes nothing, where one is out of range or not finite, or lengths differ. O(points).
  void set_forces(std::span<const Index> points, std::span<const Vec3> forces);
  /// Loads surface triangles with a pressure (Pa, against the outward normal) from the next step on, in place
  /// of the one that was set before; 0 takes it off. It follows the surface, and adds to the model's loads.
  /// Throws Error, and changes nothing, on a triangle out of range, one of a rigid body, and a pressure that
  /// is not finite. O(triangles).
  void set_pressure(std::span<const Index> triangles, double pressure);
  /// Puts points elsewhere, or gives them other velocities (m, m/s), values[i] to points[i]; the contacts are
  /// those at the new positions at once. Throw Error, and change nothing, on a point out of range, a
  /// prescribed one (and for velocities one that is fixed, or a velocity along an axis that is), a value that
  /// is not finite, and lengths that differ. O(all points), and for positions a detection.
  void set_positions(std::span<const Index> points, std::span<const Vec3> positions);
  /// As set_positions(), for velocities; needs no detection.
  void set_velocities(std::span<const Index> points, std::span<const Vec3> velocities);
  /// Pulls a point by a spring from the next step on; returns the number of the grab. The spring is damped
  /// critically against the mass of the point. Throws Error on a point out of range, a stiffness that is not
  /// a number > 0 and a target that is not finite.
  Index grab(const Grab& grab);
  /// Another target for a grab. Throws Error on a number that is no grab's.
  void move_grab(Index number, const Vec3& target);
  /// Removes a grab; its number is used again by a later grab(). Throws Error on a number that is no
  /// grab's.
  void release(Index number);
  /// Force of a grab on its point over the last step, N. Throws Error on a number that is no grab's.
  [[nodiscard]] Vec3 grab_force(Index number) const;

  [[nodiscard]] const Bodies& bodies() const;                ///< with the rest positions
  [[nodiscard]] const SimulationSettings& settings() const;  ///< of the next step
  [[nodiscard]] std::span<const Vec3> positions() const;     ///< (n_points x 3)
  [[nodiscard]] std::span<const Vec3> velocities() const;    ///< (n_points x 3)
  [[nodiscard]] const Detector& detector() const;            ///< contacts at positions()
  [[nodiscard]] const StepMetrics& metrics() const;          ///< of the last step, or of the start
  /// Whether metrics().fastest_body has been at most settings().rest.speed for settings().rest.time without a
  /// break.
  [[nodiscard]] bool at_rest() const;
  /// Force on each body by contacts during the last step, N: (n_bodies x 3). They add up to zero.
  [[nodiscard]] std::span<const Vec3> contact_forces() const;
  /// The contacts that the last step was solved with, and their forces. A copy: O(contacts).
  [[nodiscard]] ContactForces acting_contacts() const;
  /// Force and torque on a body by contacts during the last step, about its centre of mass or another point.
  /// Arms are those at positions(). Throws Error on a body out of range. O(contacts).
  [[nodiscard]] Wrench contact_wrench(Index body) const;
  /// The same about a given point, m.
  [[nodiscard]] Wrench contact_wrench(Index body, const Vec3& about) const;
  /// The same for each two bodies that touched, sorted by (body_a, body_b): they add up to zero.
  /// O(contacts log).
  [[nodiscard]] std::vector<PairWrench> pair_wrenches() const;
  /// The same as loads on the surface triangles at positions(). O(contacts + triangles).
  [[nodiscard]] SurfaceTractions tractions() const;
  /// Force of each of ties() on its point during the last step, N: (n_ties x 3).
  [[nodiscard]] std::span<const Vec3> tie_forces() const;
  /// Whether steps compute the reactions at points that are not free: reactions(). Off at first: it costs a
  /// pass over the tets at such points. O(tets).
  void record_reactions(bool on);
  /// Reaction force at each fixed or prescribed point during the last step, N: (n_points x 3), zero at free
  /// points. With it Newton's law holds for each of these points: it carries the weight of the point and
  /// what accelerates it, and what tissue, contacts, ties, grabs and loads pull. Of points with fixed axes
  /// the force along these axes, else zero. Throws Error where the last step did not compute them.
  [[nodiscard]] std::span<const Vec3> reactions() const;
  /// Sum of reactions() over the points of a body, with the torque at positions(). Throws Error as
  /// reactions() does, and on an index out of range. O(points).
  [[nodiscard]] Wrench reaction_of_body(Index body, const Vec3& about) const;
  /// The same over the points on a motion: what its motor had to give, for the body and the tissue attached
  /// to it.
  [[nodiscard]] Wrench reaction_of_motion(Index motion, const Vec3& about) const;
  /// Centre of mass of a body at positions(). Throws Error on a body out of range. O(points of the body).
  [[nodiscard]] Vec3 center_of_mass(Index body) const;
  /// Strain and stress of each tet at positions(): (n_tets). O(tets), parallel.
  [[nodiscard]] TissueState tissue() const;
  /// The same for each point: (n_points), means over the tets around it by their volumes at rest. Stress does
  /// not go over borders of materials: where tets of several meet at a point, those of the material with the
  /// most volume there count (of equal ones the first). What follows from the stress follows from its mean.
  /// O(tets), parallel.
  [[nodiscard]] TissueState tissue_at_points() const;
  /// The same from the result of tissue(), for callers who need both.
  [[nodiscard]] TissueState tissue_at_points(const TissueState& of_tets) const;
  /// Mass of each point, kg: (n_points).
  [[nodiscard]] std::span<const double> point_masses() const;
  /// Mass of each body, kg: (n_bodies).
  [[nodiscard]] std::span<const double> masses() const;
  /// Per body the material that contact stiffness is derived from: its own, or, of a body with several, its
  /// own with the mean of Young's modulus by volume.
  [[nodiscard]] std::span<const Material> contact_materials() const;
  /// 16 hexadecimal digits that stand for the bits of all positions and velocities (64-bit FNV-1a of their
  /// bytes).
  [[nodiscard]] std::string state_hash() const;

  /// The state as bytes: all that later steps depend on, and the results of the last step except times.
  /// Checksummed; of one version of the library. O(points + tets + contacts).
  [[nodiscard]] std::vector<std::byte> save() const;
  /// Continues from the result of save(): steps from there on have the bits that they would have had, for
  /// every structure, order, sort and thread count. Loads, grabs and what a ModelChange changed come from the
  /// saved state, so that references are invalid as after change(). Throws Error, and changes nothing, on
  /// bytes that are cut off, changed or of another version, and on the state of another simulation: one with
  /// other bodies, materials, motions or settings that steps depend on.
  void restore(std::span<const std::byte> saved);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate

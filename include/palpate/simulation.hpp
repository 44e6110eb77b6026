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

/// Metrics of one step. Counts and energies are the same in every run; times are not.
struct StepMetrics {
  std::int64_t step = 0;      ///< steps done; 0 is the start
  double time = 0.0;          ///< s, of the simulation
  DetectionCounts detection;  ///< at the end of the step
  /// Solves of the step's system; more than one where bodies meet within the step, or rotate
  /// fast, or where it was divided.
  int solves = 0;
  /// More than one where bodies met, where bodies that rotate touch others, or where it was divided.
  int detections = 0;
  int substeps = 1;                       ///< more than one where the whole step did not converge
  std::int64_t speculative_contacts = 0;  ///< contacts of the step that were found within it
  /// Stopped points and edges that would have passed through another body and ended on the wrong side
  /// (docs/continuous.md).
  std::int64_t stopped_passes = 0;
  /// Points and edges left on the wrong side: they could not be stopped, or the search was limited. Counted
  /// unless ContinuousDetection::off.
  std::int64_t passes = 0;
  /// Pairs of bodies that could meet, with a relative motion so large that parts could pass through; where
  /// contacts may be missing (DetectionCounts::dropped_cells, completeness, unseen_pairs), with any relative
  /// motion.
  std::int64_t pairs_that_could_pass = 0;
  double thinnest = 0.0;         ///< m, least local thickness of these parts; 0: none
  bool looks_ahead = true;       ///< whether there was time to search for speculative contacts
  int solver_iterations = 0;     ///< of all solves
  bool solver_converged = true;  ///< whether each solve converged, of all substeps
  int order = 1;                 ///< of the time integration: 2 where the step was BDF2
  double kinetic_energy = 0.0;   ///< J, of points that are free to move
  double elastic_energy = 0.0;   ///< J
  double largest_speed = 0.0;    ///< m/s, over all points, prescribed ones included
  double fastest_body = 0.0;     ///< m/s, largest root mean square speed (by mass) of a body
  /// m, largest penetration depth: of points, and of edges where two bodies touch only by edges. (Elsewhere
  /// edges of uneven faces are deeper than the points.)
  double deepest = 0.0;
  std::int64_t inverted_tets =
      0;  ///< tets of deformable bodies without positive volume, at the end of the step
  DetectionTimes detection_seconds;  ///< of all detections
  double forces_seconds = 0.0;       ///< contact forces
  double solver_seconds = 0.0;       ///< elastic forces, assembly and linear solve
};

/// Soft bodies under gravity, with contact: the step of positions -> contacts -> forces -> implicit Euler.
///
/// After each step the contacts are those at the new positions. The same input gives the same bits for every
/// structure, order, sort and thread count.
class Simulation {
 public:
  /// Throws Error on a setting, material, motion, force, grab or tie out of range, and on arrays whose length
  /// does not match the bodies.
  /// \param model    bodies, materials, constraints and loads; prescribed points start at the pose of their
  ///                 motion at time 0
  /// \param threads  number of threads; 0 takes all
  Simulation(Model model, const SimulationSettings& settings, int threads = 0);
  ~Simulation();
  /// A moved-from simulation can only be assigned to or destroyed.
  Simulation(Simulation&&) noexcept;
  /// Frees the data of this simulation; the other can then only be assigned to or destroyed.
  Simulation& operator=(Simulation&&) noexcept;

  /// Advances by one time step. Throws Error if the run blows up (a value that is not finite, or beyond
  /// settings().limits), naming body, tet and step: source "body NAME", where "tet T, step N". Then all
  /// results (positions, velocities, contacts, metrics, forces) belong to the last good step.
  const StepMetrics& step();

  /// Changes the settings from the next step on; positions, velocities, grabs and the state of contacts stay.
  /// If detection settings differ, contacts at positions() are detected again. Throws Error, and changes
  /// nothing, on a setting that the constructor would refuse, and on a different time step, since it must
  /// stay constant. O(1); a new detector and a detection if detection settings differ.
  void change(const SimulationSettings& settings);
  /// Changes constraints, motions, ties and loads from the next step on. Released points keep their velocity,
  /// fixed or removed ones stand still. Positions stay, except those of inserted prescribed bodies. Contacts
  /// of removed bodies end at once. Invalidates spans and references of this class, except bodies(). Throws
  /// Error, and changes nothing, on an index out of range, the release of a single point of a rigid body, and
  /// what the constructor would refuse. A removed body loses its plastic strain. O(points + tets log), a new
  /// detector and a detection, like the constructor.
  void change(const ModelChange& change);
  /// Whether a body is present: Model::absent, ModelChange. Throws Error on a body out of range.
  [[nodiscard]] bool is_present(Index body) const;
  /// Whether a body is rigid: Model::obstacles, until it is released. Throws Error on a body out of range.
  [[nodiscard]] bool is_rigid(Index body) const;
  /// The current ties.
  [[nodiscard]] std::vector<Tie> ties() const;
  /// (n_points) the motion of each point, or -1.
  [[nodiscard]] std::span<const Index> motion_of_points() const;
  /// Number of motions: those of the model and those that a ModelChange added.
  [[nodiscard]] Index motion_count() const;
  /// Replaces a motion of the model. At the end of the next step, its points are at the new pose, from
  /// wherever they were. Throws Error, and changes nothing, on a number out of range and on a motion that the
  /// constructor would refuse. O(keyframes).
  void set_motion(Index number, Motion motion);
  /// Moves the points of a motion to this pose during the next step, at constant speed, where they stay: a
  /// motion with this single keyframe about the same center. Its time is ignored. Throws Error, and changes
  /// nothing, as set_motion() does. O(1).
  void move_to(Index number, const Keyframe& pose);
  /// The current motion with this number. Throws Error on a number out of range.
  [[nodiscard]] const Motion& motion(Index number) const;
  /// Sets the force (N) on a point from the next step on; replaces the one set before (at first that of
  /// Model::forces), and zero removes it. It adds to all other loads of the model. Throws Error on a point
  /// out of range or of a rigid or removed body, and a force that is not finite.
  void set_force(Index point, const Vec3& force);
  /// set_force() for many points: forces[i] on points[i]; for a repeated point the last one holds. Throws
  /// Error as set_force(), and if lengths differ, and changes nothing. O(points).
  void set_forces(std::span<const Index> points, std::span<const Vec3> forces);
  /// Sets a pressure (Pa, against the outward normal) on surface triangles from the next step on; replaces
  /// the one set before, and 0 removes it. It follows the surface, and adds to the model's loads. Throws
  /// Error, and changes nothing, on a triangle out of range, one of a rigid body, and a pressure that is not
  /// finite. O(triangles).
  void set_pressure(std::span<const Index> triangles, double pressure);
  /// Sets a pressure for each triangle: pressures[i] on triangles[i]; for a repeated triangle the last one
  /// holds. Throws Error also if lengths differ.
  void set_pressure(std::span<const Index> triangles, std::span<const double> pressures);
  /// Sets positions of points (m), values[i] to points[i], and detects the contacts there. Throws Error, and
  /// changes nothing, on a point out of range, a prescribed one, one of a rigid body (it would deform: give
  /// it a motion), a value that is not finite, and different lengths. O(all points), and a detection.
  void set_positions(std::span<const Index> points, std::span<const Vec3> positions);
  /// Sets velocities of points (m/s) like set_positions(), without a detection. Throws Error also on a fixed
  /// point, and on a velocity along a fixed axis.
  void set_velocities(std::span<const Index> points, std::span<const Vec3> velocities);
  /// Pulls a point by a spring from the next step on; returns the number of the grab. The spring is damped
  /// critically against the mass of the point. Throws Error on a point out of range or of a rigid or
  /// removed body, a stiffness that is not a number > 0 and a target that is not finite.
  Index grab(const Grab& grab);
  /// Sets the target of a grab. Throws Error if it is not the number of a grab.
  void move_grab(Index number, const Vec3& target);
  /// Removes a grab; its number is reused by a later grab(). Throws Error if it is not the number of a grab.
  void release(Index number);
  /// Force of a grab on its point over the last step, N. Throws Error if it is not the number of a grab.
  [[nodiscard]] Vec3 grab_force(Index number) const;
  /// Numbers of the active grabs, ascending. Those of a model are 0, 1, ... in its order.
  [[nodiscard]] std::vector<Index> grabs() const;
  /// A grab with its current target. Throws Error if it is not the number of a grab.
  [[nodiscard]] const Grab& grab_of(Index number) const;

  [[nodiscard]] const Bodies& bodies() const;                ///< meshes and rest positions
  [[nodiscard]] const SimulationSettings& settings() const;  ///< of the next step
  [[nodiscard]] std::span<const Vec3> positions() const;     ///< (n_points x 3)
  [[nodiscard]] std::span<const Vec3> velocities() const;    ///< (n_points x 3)
  /// (n_points) 1 for points that are neither fixed nor prescribed.
  [[nodiscard]] std::span<const std::uint8_t> free_points() const;
  [[nodiscard]] const Detector& detector() const;    ///< contacts at positions()
  [[nodiscard]] const StepMetrics& metrics() const;  ///< of the last step, or of the start
  /// Whether metrics().fastest_body has been at most settings().rest.speed for settings().rest.time without
  /// interruption, in steps that converged (or have fixed iterations).
  [[nodiscard]] bool at_rest() const;
  /// Force on each body by contacts during the last step, N: (n_bodies x 3). They add up to zero.
  [[nodiscard]] std::span<const Vec3> contact_forces() const;
  /// The contacts of the last solve of the last step, with their forces. A copy: O(contacts).
  [[nodiscard]] ContactForces acting_contacts() const;
  /// Force and torque on a body by contacts during the last step, about its centre of mass or another point.
  /// Arms are those at positions(). Throws Error on a body out of range. O(contacts).
  [[nodiscard]] Wrench contact_wrench(Index body) const;
  /// Force and torque on a body, about a given point, m. Throws Error also on a point that is not finite.
  [[nodiscard]] Wrench contact_wrench(Index body, const Vec3& about) const;
  /// Force and torque between each two bodies in contact, sorted by (body_a, body_b). Torques are about the
  /// centre of mass of body_b. O(contacts log).
  [[nodiscard]] std::vector<PairWrench> pair_wrenches() const;
  /// pair_wrenches() with all torques about a given point, m. Throws Error on a point that is not finite.
  [[nodiscard]] std::vector<PairWrench> pair_wrenches(const Vec3& about) const;
  /// The contact forces of the last step as loads on the surface triangles at positions(). O(contacts +
  /// triangles).
  [[nodiscard]] SurfaceTractions tractions() const;
  /// Force of each of ties() on its point during the last step, N: (n_ties x 3). The tet feels the opposite.
  [[nodiscard]] std::span<const Vec3> tie_forces() const;
  /// Force and torque on a body by all of its ties during the last step, about a point, m, at positions().
  /// Throws Error on a body out of range and a point that is not finite. O(ties).
  [[nodiscard]] Wrench tie_wrench(Index body, const Vec3& about) const;
  /// Force and torque on a body by all grabs of its points, as tie_wrench(). O(grabs).
  [[nodiscard]] Wrench grab_wrench(Index body, const Vec3& about) const;
  /// Sets whether steps compute the reactions at fixed and prescribed points: reactions(). Off by default: it
  /// costs a pass over the tets at such points. O(tets).
  void record_reactions(bool on);
  /// Reaction force at each fixed or prescribed point during the last step, N: (n_points x 3), zero at free
  /// points. It balances the weight and inertia of the point, and the forces of tissue, contacts, ties, grabs
  /// and loads on it. For points with fixed axes it is the force along these axes. Throws Error if the
  /// last step did not compute them.
  [[nodiscard]] std::span<const Vec3> reactions() const;
  /// Sum of reactions() over the points of a body, with the torque at positions(). Throws Error as
  /// reactions() does, on an index out of range and on a point that is not finite. O(points).
  [[nodiscard]] Wrench reaction_of_body(Index body, const Vec3& about) const;
  /// Sum of reactions() over the points on a motion, with the torque at positions(): the force and torque of
  /// its motor, for the body and the tissue attached to it.
  [[nodiscard]] Wrench reaction_of_motion(Index motion, const Vec3& about) const;
  /// Centre of mass of a body at positions(). Throws Error on a body out of range. O(points of the body).
  [[nodiscard]] Vec3 center_of_mass(Index body) const;
  /// Strain and stress of each tet at positions(): (n_tets). O(tets), parallel.
  /// \param memory  a state that is no longer needed, for example the last one: its arrays are used again, so
  ///   a loop allocates nothing
  [[nodiscard]] TissueState tissue(TissueState memory = {}) const;
  /// Strain and stress of each point: (n_points), means over the tets around it, weighted by their volumes
  /// at rest.
  /// Stress is not averaged over different materials: only tets of the material with the most volume at the
  /// point are used (of equal ones the first). Quantities derived from the stress are derived from its mean.
  /// For callers who need tissue() too, `of_tets` saves computing the strain of the tets again. O(tets),
  /// parallel.
  [[nodiscard]] TissueState tissue_at_points() const;
  /// tissue_at_points() from the result of tissue(). Throws Error on a different number of rows.
  [[nodiscard]] TissueState tissue_at_points(const TissueState& of_tets, TissueState memory = {}) const;
  /// Mass of each point, kg: (n_points).
  [[nodiscard]] std::span<const double> point_masses() const;
  /// Mass of each body, kg: (n_bodies).
  [[nodiscard]] std::span<const double> masses() const;
  /// For each body, the material from which contact stiffness is derived: its own; for a body with several,
  /// its own with Young's modulus and Poisson's ratio averaged by volume.
  [[nodiscard]] std::span<const Material> contact_materials() const;
  /// 16 hexadecimal digits that stand for the bits of all positions and velocities (64-bit FNV-1a of their
  /// bytes).
  [[nodiscard]] std::string state_hash() const;

  /// The state as bytes: all that later steps depend on, and the results of the last step except times. With
  /// a checksum; only for the same version of the library. O(points + tets + contacts).
  [[nodiscard]] std::vector<std::byte> save() const;
  /// Continues from the result of save(): further steps have the same bits as without the interruption, for
  /// every structure, order, sort and thread count. Loads, grabs and changes by ModelChange and of settings
  /// come from the saved state, so references are invalid as after change(). Throws Error, and changes
  /// nothing, on bytes that are truncated, changed or of a different version, and on the state of a
  /// simulation with different bodies, materials or motions, or that began with other settings that affect
  /// steps.
  void restore(std::span<const std::byte> saved);

 private:
  friend class SimulationPath;
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate

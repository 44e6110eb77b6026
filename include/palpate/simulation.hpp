#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate {

/// What one step did. Counts and energies are the same on every run; times are of this one.
struct StepMetrics {
  std::int64_t step = 0;      ///< steps done; 0 is the start
  double time = 0.0;          ///< s, of the simulation
  DetectionCounts detection;  ///< at the end of the step
  int solves =
      0;  ///< linear solves; more than one where contacts change between stick and slide, or bodies meet
  int detections = 0;                ///< more than one where bodies met within the step
  bool looks_ahead = true;           ///< false: the budget left no time to foresee contacts
  int solver_iterations = 0;         ///< of all solves
  bool solver_converged = true;      ///< each solve
  double kinetic_energy = 0.0;       ///< J
  double elastic_energy = 0.0;       ///< J
  double largest_speed = 0.0;        ///< m/s, over all points
  double fastest_body = 0.0;         ///< m/s, largest root mean square speed (by mass) of a body
  double deepest = 0.0;              ///< m, largest penetration depth
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
  /// \param model    what moves; points on rails start where their motion is at time 0
  /// \param threads  number of threads; 0 takes all
  /// Throws Error on a setting, material, motion, force, grab or tie out of range, and on arrays of another
  /// length than the bodies have.
  Simulation(Model model, const SimulationSettings& settings, int threads = 0);
  ~Simulation();
  /// A moved-from simulation can only be assigned to or destroyed.
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// Advances by one time step. Throws Error where the run blows up (a value that is not finite, or beyond
  /// settings().limits), naming body, tet and step: source "body NAME", where "tet T, step N". Then all that
  /// this class tells (positions, velocities, contacts, metrics, forces) is that of the last good step.
  const StepMetrics& step();

  /// Other settings from the next step on; positions, velocities, grabs and what contacts remember stay.
  /// Other detection settings find the contacts at positions() anew. Throws Error, and changes nothing, on a
  /// setting that the constructor would refuse and on another time step: steps are counted in it. O(1), and a
  /// detection with its preparation where detection settings differ.
  void change(const SimulationSettings& settings);
  /// Another motion in place of a motion of the model: points on it are where it has them at the end of the
  /// next step, wherever they were. Throws Error, and changes nothing, on a number out of range and on a
  /// motion that the constructor would refuse. O(keyframes).
  void set_motion(Index number, Motion motion);
  /// Loads a point with a force (N) from the next step on, in place of the one before; zero takes it off.
  /// Throws Error on a point out of range and a force that is not finite.
  void set_force(Index point, const Vec3& force);
  /// Pulls a point by a spring from the next step on; returns the number of the grab. The spring is damped
  /// critically against the mass of the point. Throws Error on a point out of range, a stiffness that is not
  /// a number > 0 and a target that is not finite.
  Index grab(const Grab& grab);
  /// Another target for a grab. Throws Error on a number that is no grab's.
  void move_grab(Index number, const Vec3& target);
  /// Lets go of a point; its number is used again by a later grab(). Throws Error on a number that is no
  /// grab's.
  void release(Index number);
  /// Force of a grab on its point over the last step, N. Throws Error on a number that is no grab's.
  [[nodiscard]] Vec3 grab_force(Index number) const;

  [[nodiscard]] const Bodies& bodies() const;  ///< with the rest positions
  [[nodiscard]] const SimulationSettings& settings() const;
  [[nodiscard]] std::span<const Vec3> positions() const;   ///< (n_points x 3)
  [[nodiscard]] std::span<const Vec3> velocities() const;  ///< (n_points x 3)
  [[nodiscard]] const Detector& detector() const;          ///< contacts at positions()
  [[nodiscard]] const StepMetrics& metrics() const;        ///< of the last step, or of the start
  /// Whether metrics().fastest_body has been at most settings().rest.speed for settings().rest.time without a
  /// break.
  [[nodiscard]] bool at_rest() const;
  /// Force on each body by contacts during the last step, N: (n_bodies x 3). They add up to zero.
  [[nodiscard]] std::span<const Vec3> contact_forces() const;
  /// Mass of each body, kg: (n_bodies).
  [[nodiscard]] std::span<const double> masses() const;
  /// Per body the material that contact stiffness is derived from: its own, or, of a body with several, its
  /// own with the mean of Young's modulus by volume.
  [[nodiscard]] std::span<const Material> contact_materials() const;
  /// 16 hexadecimal digits that stand for the bits of all positions and velocities (64-bit FNV-1a of their
  /// bytes).
  [[nodiscard]] std::string state_hash() const;

  /// The state as bytes: all that later steps depend on, and what this class tells of the last step but for
  /// times. Checksummed; of one version of the library. O(points + tets + contacts).
  [[nodiscard]] std::vector<std::byte> save() const;
  /// Goes on from what save() gave: steps from there on have the bits that they would have had, for every
  /// structure, order, sort and thread count. Loads and grabs come from the saved state. Throws Error, and
  /// changes nothing, on bytes that are cut off, changed or of another version, and on the state of another
  /// simulation: one with other bodies, materials, motions or settings that steps depend on.
  void restore(std::span<const std::byte> saved);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate

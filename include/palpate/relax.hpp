#pragma once

#include <cstddef>
#include <functional>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate {

/// Settings of the removal of overlaps: when they count as removed.
struct RelaxSettings {
  double depth = 0.01;  ///< allowed depth over the smallest mean edge length of a body; > 0
  int max_steps = 200;  ///< cap, > 0
};

/// The result of relax().
struct RelaxReport {
  int steps = 0;  ///< number of steps made
  /// True: no contact is deeper than allowed; false: the cap was reached, or nothing could move.
  bool relaxed = false;
  std::size_t contacts_before = 0;  ///< at the positions given
  std::size_t contacts_after = 0;   ///< at the positions reached
  double deepest_before = 0.0;      ///< m, of contacts of which at least one side can move
  double deepest_after = 0.0;       ///< m, of the same contacts
  double allowed_depth = 0.0;       ///< m
  double largest_move = 0.0;        ///< m, largest displacement of a point
};

/// Removes the overlaps of bodies that should only touch (organs from a segmentation), before a run.
///
/// Nearly quasi-static: in each step (of ten time steps of the scene) bodies move towards the equilibrium of
/// elastic and contact forces, linearised as in a simulation, but from rest, without gravity, loads, friction
/// and plasticity, and by at most the largest depth. If the depth decreases by less than a tenth in a step,
/// the contact stiffness is doubled (up to 1024 times), so that also stiff tissue deforms in the end. A step
/// that would crush tissue is halved. What does not move in a run does not move here. The positions reached
/// become the rest positions of the model: overlaps are errors of the geometry, and the tissue starts without
/// stress.
///
/// No tet is compressed below a tenth of its volume: overlaps that need more stay, and the report says so.
/// Contacts in which nothing can move (attached tissue inside its own bone) also stay and do not count as
/// overlaps. `model` is changed only at the end. Throws Error as Simulation does.
/// `progress` is called after each step with the number of steps and the deepest contact (m); it may throw to
/// stop. O(steps x step of a simulation).
RelaxReport relax(Model& model, const SimulationSettings& settings, const RelaxSettings& relaxation,
                  int threads = 0, const std::function<void(int, double)>& progress = {});

}  // namespace palpate

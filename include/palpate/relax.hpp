#pragma once

#include <cstddef>
#include <functional>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate {

/// When overlaps at the start count as removed.
struct RelaxSettings {
  double depth = 0.01;  ///< no contact deeper than this fraction of the least mean edge length of a body; > 0
  int max_steps = 200;  ///< cap, > 0
};

/// What relax() did.
struct RelaxReport {
  int steps = 0;  ///< done
  bool relaxed =
      false;  ///< no contact is deeper than allowed; false: the cap was reached, or nothing could move
  std::size_t contacts_before = 0;  ///< at the positions given
  std::size_t contacts_after = 0;   ///< at the positions reached
  double deepest_before = 0.0;      ///< m, of contacts of which a side can move
  double deepest_after = 0.0;       ///< m, of those, too
  double allowed_depth = 0.0;       ///< m
  double largest_move = 0.0;        ///< m, of a point from its place before
};

/// Removes the overlaps of bodies that should only touch (organs from a segmentation), before a run.
///
/// Nearly quasi-static: in each step (of ten time steps of the scene) bodies move towards the equilibrium of
/// elastic and contact forces, linearised as in a simulation, but from rest, with no gravity, loads, friction
/// or plasticity, and no further than the deepest contact is deep. Where the depth falls by less than a tenth
/// from one step to the next the contact stiffness is doubled (up to 1024 times), so that in the end the
/// tissue deforms however stiff it is; where a step would crush tissue it is halved. What does not move in
/// a run stays here too. The positions reached become the rest positions of the model: overlaps are errors of
/// the geometry, and the tissue starts without stress.
///
/// No tet gets flatter than a tenth of its volume: overlaps that ask for more stay, and the report says so.
/// Contacts in which nothing can move (attached tissue inside its own bone) stay too and do not count as
/// overlaps. `model` changes only when all is done. Throws Error as Simulation
/// does. `progress` is called after each step with the number of steps and the deepest contact (m); it may
/// throw to stop. O(steps x step of a simulation).
RelaxReport relax(Model& model, const SimulationSettings& settings, const RelaxSettings& relaxation,
                  int threads = 0, const std::function<void(int, double)>& progress = {});

}  // namespace palpate

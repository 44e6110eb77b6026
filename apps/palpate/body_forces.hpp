#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "scene/scene.hpp"

namespace palpate::app {

/// The force and torque on a body in the last step; torques are about its centre of mass.
struct BodyForces {
  Wrench contact{};              ///< by contacts
  std::optional<Wrench> held{};  ///< by what holds its fixed points; for a body with a prescribed motion, by
                                 ///< the motor that moves it
  std::optional<Wrench> tied{};  ///< by its ties to other bodies
  std::optional<Wrench> grabbed{};  ///< by grabs of its points
};

/// The forces of a step.
struct ForcesOfStep {
  std::vector<BodyForces> bodies;  ///< (n_bodies)
  /// For each pair of bodies that the scene names: the wrench of the first body on the second. The torque is
  /// about the centre of mass of the second.
  std::vector<PairWrench> pairs;
  double normal = 0.0;   ///< sum of the normal forces of all contacts
  double largest = 0.0;  ///< force of contacts on a body
};

/// Computes the forces on all bodies, and those between pairs that a scene names.
class ForceProbe {
 public:
  /// Finds which bodies are held.
  /// \param obstacles  (n_bodies) as the model has them
  ForceProbe(const Scene& scene, const Model& model);

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  [[nodiscard]] bool is_held(std::size_t body) const { return held_[body] != 0; }
  /// Whether the model or a stage ties it to another body.
  [[nodiscard]] bool is_tied(std::size_t body) const { return tied_[body] != 0; }
  [[nodiscard]] bool is_grabbed(std::size_t body) const { return grabbed_[body] != 0; }
  /// The forces of the last step. O(contacts log contacts + points).
  [[nodiscard]] ForcesOfStep forces(const Simulation& simulation) const;

  /// Two bodies that the scene names, in its order.
  struct Pair {
    Index first;
    Index second;
  };
  [[nodiscard]] const std::vector<Pair>& pairs() const { return pairs_; }

 private:
  void add_contacts(const std::vector<PairWrench>& touching, ForcesOfStep& all) const;
  void add_held(const Simulation& simulation, ForcesOfStep& all) const;
  [[nodiscard]] PairWrench force_of(const Pair& named, const std::vector<PairWrench>& touching,
                                    const Vec3& center) const;

  std::vector<std::string> names_;
  std::vector<std::uint8_t>
      held_;  ///< (n_bodies) 1: a point of it is prescribed, or fixed along at least one axis
  std::vector<std::uint8_t> tied_;     ///< (n_bodies)
  std::vector<std::uint8_t> grabbed_;  ///< (n_bodies)
  std::vector<Index> motions_;         ///< (n_bodies) the body's own motion, or -1
  std::vector<Pair> pairs_;
};

/// The largest contact force on a body during a run.
struct LargestForce {
  double force = 0.0;
  std::int64_t step = 0;
};

}  // namespace palpate::app

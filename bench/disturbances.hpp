#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <palpate/simulation.hpp>

namespace palpate::bench {

/// splitmix64: the same numbers on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform(double low, double high);
  Vec3 in_ball(double radius);

 private:
  std::uint64_t state_;
};

/// Pushes, grabs and other paths for prescribed bodies, by the sizes of the scene and drawn from a seed:
/// every few steps a point is pushed, or grabbed, moved about and released; prescribed bodies (jaws, plates)
/// move back and forth near their path.
class Disturbances {
 public:
  /// \param motions  those of the scene
  /// \param rigid    (n_bodies) 1 for each body that is rigid
  Disturbances(const Simulation& simulation, std::vector<Motion> motions, std::span<const std::uint8_t> rigid,
               std::uint64_t seed);

  /// Call before a step. Also changes the motions of `others`, into which a state will be restored, since
  /// states do not contain them.
  void apply(Simulation& simulation, std::span<Simulation> others = {});

 private:
  struct Soft {
    Range points;
    double inertia;  ///< mass of a point over the time step squared, N/m
  };
  void push(Simulation& simulation);
  void hold(Simulation& simulation);
  void redirect(Simulation& simulation, std::span<Simulation> others);
  std::pair<Index, double> any_point();

  Random random_;
  std::vector<Motion> motions_;  ///< those of the scene
  std::vector<Keyframe> poses_;  ///< target of each
  std::vector<Soft> soft_;
  double edge_ = 0.0;  ///< mean, m
  Index pushed_ = -1;
  Index grab_ = -1;  ///< its number; -1: none
  Vec3 home_{};
};

}  // namespace palpate::bench

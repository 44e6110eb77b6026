#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include <palpate/simulation.hpp>

#include "view/command.hpp"

namespace palpate::view {

/// Moves what is on rails by hand: along its path, or off it, and never faster than tissue can follow.
///
/// Rails that nobody touches are left alone, so that a run that is only looked at has the bits of any other.
class RailsControl {
 public:
  /// \param longest_step  how far an offset moves in a step at most
  RailsControl(std::vector<Motion> paths, double longest_step);

  /// Each throws Error on a number out of range.
  void move(const MoveRails& rails, double now);
  void run(const RunRails& rails, double now);

  /// Before a step from `now`: tells the simulation where it leads what is moved by hand.
  void lead(Simulation& simulation, double now, double time_step);
  void reset();

  /// Whether a hand holds any.
  [[nodiscard]] bool holds() const;
  /// For each of the rails: its body's time on the path, its offset, whether it is held.
  [[nodiscard]] nlohmann::ordered_json json(double now) const;

 private:
  struct Rail {
    Motion path;
    bool touched = false;
    bool held = false;  ///< stays where it is led; else it follows its path in time
    double time = 0.0;
    double wanted_time = 0.0;
    Vec3 offset{};
    Vec3 wanted_offset{};
  };
  Rail& touch(Index motion, double now);
  static Keyframe pose(const Rail& rail, double now);

  std::vector<Rail> rails_;
  double longest_step_;
};

}  // namespace palpate::view

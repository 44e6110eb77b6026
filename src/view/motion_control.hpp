#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include <palpate/simulation.hpp>

#include "view/command.hpp"

namespace palpate::view {

/// Moves bodies with a prescribed motion by hand: along the path, or off it, and never faster than tissue can
/// follow.
///
/// Other motions are not changed, so that watching a run does not change its bits.
class MotionControl {
 public:
  /// \param longest_step  largest change of an offset in a step
  MotionControl(std::vector<Motion> paths, double longest_step);

  /// Each throws Error on a number out of range.
  void move(const DriveMotion& command, double now);
  void run(const ResumeMotion& command, double now);

  /// Before a step from `now`: sets the poses of the bodies that are moved by hand.
  void lead(Simulation& simulation, double now, double time_step);
  void reset();

  /// Whether any body is moved by hand.
  [[nodiscard]] bool holds() const;
  /// For each motion: its body's time on the path, its offset, whether it is held.
  [[nodiscard]] nlohmann::ordered_json json(double now) const;

 private:
  struct DrivenMotion {
    Motion path;
    bool touched = false;
    bool held = false;  ///< moved by hand; else it follows its path in time
    double time = 0.0;
    double wanted_time = 0.0;
    Vec3 offset{};
    Vec3 wanted_offset{};
  };
  DrivenMotion& touch(Index motion, double now);
  static Keyframe pose(const DrivenMotion& driven, double now);

  std::vector<DrivenMotion> motions_;
  double longest_step_;
};

}  // namespace palpate::view

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
  /// \param paths         motions 0, 1, ... of the simulation
  /// \param longest_step  largest change of an offset in a step
  MotionControl(const std::vector<Motion>& paths, double longest_step);

  /// Appends a body that no motion moves yet.
  void add_unmoved() { motions_.emplace_back(); }
  /// Gives a body another motion of the simulation, which takes it from the hand that holds it.
  /// \param body    position in the list of this class
  /// \param number  of the motion; -1: none, then the path is ignored
  void replace(std::size_t body, Index number, Motion path);

  /// Each throws Error on a number out of range.
  void move(const DriveMotion& command, double now);
  void run(const ResumeMotion& command, double now);

  /// Before a step from `now`: sets the poses of the bodies that are moved by hand.
  void lead(Simulation& simulation, double now, double time_step);

  /// Whether any body is moved by hand.
  [[nodiscard]] bool holds() const;
  /// The number of a body's motion; -1: none.
  [[nodiscard]] Index number(std::size_t body) const { return motions_[body].number; }
  /// For each body: its time on the path, its offset, whether it is held, and the times of the path.
  [[nodiscard]] nlohmann::ordered_json json(double now) const;

 private:
  struct DrivenMotion {
    Index number = -1;  ///< of the simulation; -1: nothing moves this body
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

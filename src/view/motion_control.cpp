#include "view/motion_control.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

namespace palpate::view {
namespace {

/// Largest speed of a motion by hand along its path, relative to its own speed.
constexpr double fastest_path = 4.0;

}  // namespace

MotionControl::MotionControl(const std::vector<Motion>& paths, double longest_step)
    : longest_step_(longest_step) {
  for (const Motion& path : paths) motions_.push_back({static_cast<Index>(motions_.size()), path});
}

void MotionControl::replace(std::size_t body, Index number, Motion path) {
  if (number < 0) path = {};
  motions_[body] = {number, std::move(path)};
}

MotionControl::DrivenMotion& MotionControl::touch(Index motion, double now) {
  if (motion < 0 || static_cast<std::size_t>(motion) >= motions_.size()) {
    throw Error("message from the page", "motion", std::to_string(motion),
                "less than " + std::to_string(motions_.size()) + ", the number of motions");
  }
  DrivenMotion& driven = at(motions_, motion);
  if (driven.number < 0)
    throw Error("message from the page", "motion", "a body that nothing moves now", "one with a motion");
  if (!std::exchange(driven.touched, true)) driven.time = driven.wanted_time = now;
  return driven;
}

void MotionControl::move(const DriveMotion& command, double now) {
  DrivenMotion& driven = touch(command.motion, now);
  if (!std::exchange(driven.held, true)) driven.wanted_time = driven.time;
  const double first = driven.path.keyframes.front().time;
  const double last = driven.path.keyframes.back().time;
  if (command.time) driven.wanted_time = std::clamp(*command.time, first, last);
  if (command.offset) driven.wanted_offset = *command.offset;
}

void MotionControl::run(const ResumeMotion& command, double now) {
  DrivenMotion& driven = touch(command.motion, now);
  driven.held = false;
  driven.wanted_offset = {};
}

Keyframe MotionControl::pose(const DrivenMotion& driven, double now) {
  Keyframe key = pose_at(driven.path, driven.time);
  key.time = now;
  key.translate += driven.offset;
  return key;
}

void MotionControl::lead(Simulation& simulation, double now, double time_step) {
  for (DrivenMotion& driven : motions_) {
    if (!driven.touched) continue;
    const Keyframe begin = pose(driven, now);
    const double most = fastest_path * time_step;
    driven.time += driven.held ? std::clamp(driven.wanted_time - driven.time, -most, most) : time_step;
    const Vec3 remaining = driven.wanted_offset - driven.offset;
    const double distance = length(remaining);
    driven.offset = distance > longest_step_ ? driven.offset + (longest_step_ / distance) * remaining
                                             : driven.wanted_offset;
    const Keyframe end = pose(driven, now + time_step);
    simulation.set_motion(driven.number, {driven.path.center, {begin, end}});
  }
}

bool MotionControl::holds() const {
  return std::ranges::any_of(motions_, &DrivenMotion::held);
}

nlohmann::ordered_json MotionControl::json(double now) const {
  auto list = nlohmann::ordered_json::array();
  for (const DrivenMotion& driven : motions_) {
    const std::vector<Keyframe>& keys = driven.path.keyframes;
    const bool moves = driven.number >= 0;
    list.push_back({{"time", driven.touched ? driven.time : now},
                    {"offset", {driven.offset.x, driven.offset.y, driven.offset.z}},
                    {"held", driven.held},
                    {"moves", moves},
                    {"begin", moves ? keys.front().time : 0.0},
                    {"end", moves ? keys.back().time : 0.0}});
  }
  return list;
}

}  // namespace palpate::view

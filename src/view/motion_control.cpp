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

MotionControl::MotionControl(std::vector<Motion> paths, double longest_step) : longest_step_(longest_step) {
  for (Motion& path : paths) motions_.push_back({std::move(path)});
}

MotionControl::DrivenMotion& MotionControl::touch(Index motion, double now) {
  if (motion < 0 || static_cast<std::size_t>(motion) >= motions_.size()) {
    throw Error("message from the page", "motion", std::to_string(motion),
                "less than " + std::to_string(motions_.size()) + ", the number of motions");
  }
  DrivenMotion& driven = at(motions_, motion);
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
  for (std::size_t m = 0; m < motions_.size(); ++m) {
    DrivenMotion& driven = motions_[m];
    if (!driven.touched) continue;
    const Keyframe begin = pose(driven, now);
    const double most = fastest_path * time_step;
    driven.time += driven.held ? std::clamp(driven.wanted_time - driven.time, -most, most) : time_step;
    const Vec3 remaining = driven.wanted_offset - driven.offset;
    const double distance = length(remaining);
    driven.offset = distance > longest_step_ ? driven.offset + (longest_step_ / distance) * remaining
                                             : driven.wanted_offset;
    const Keyframe end = pose(driven, now + time_step);
    simulation.set_motion(static_cast<Index>(m), {driven.path.center, {begin, end}});
  }
}

void MotionControl::reset() {
  for (DrivenMotion& driven : motions_) driven = {std::move(driven.path)};
}

bool MotionControl::holds() const {
  return std::ranges::any_of(motions_, &DrivenMotion::held);
}

nlohmann::ordered_json MotionControl::json(double now) const {
  auto list = nlohmann::ordered_json::array();
  for (const DrivenMotion& driven : motions_) {
    list.push_back({{"time", driven.touched ? driven.time : now},
                    {"offset", {driven.offset.x, driven.offset.y, driven.offset.z}},
                    {"held", driven.held}});
  }
  return list;
}

}  // namespace palpate::view

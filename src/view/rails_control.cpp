#include "view/rails_control.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

namespace palpate::view {
namespace {

/// A path may be run through so much faster than by itself.
constexpr double fastest_path = 4.0;

}  // namespace

RailsControl::RailsControl(std::vector<Motion> paths, double longest_step) : longest_step_(longest_step) {
  for (Motion& path : paths) rails_.push_back({std::move(path)});
}

RailsControl::Rail& RailsControl::touch(Index motion, double now) {
  if (motion < 0 || static_cast<std::size_t>(motion) >= rails_.size()) {
    throw Error("message from the page", "motion", std::to_string(motion),
                "less than " + std::to_string(rails_.size()) + ", the number of motions");
  }
  Rail& rail = at(rails_, motion);
  if (!std::exchange(rail.touched, true)) rail.time = rail.wanted_time = now;
  return rail;
}

void RailsControl::move(const MoveRails& rails, double now) {
  Rail& rail = touch(rails.motion, now);
  if (!std::exchange(rail.held, true)) rail.wanted_time = rail.time;
  const double first = rail.path.keyframes.front().time;
  const double last = rail.path.keyframes.back().time;
  if (rails.time) rail.wanted_time = std::clamp(*rails.time, first, last);
  if (rails.offset) rail.wanted_offset = *rails.offset;
}

void RailsControl::run(const RunRails& rails, double now) {
  Rail& rail = touch(rails.motion, now);
  rail.held = false;
  rail.wanted_offset = {};
}

Keyframe RailsControl::pose(const Rail& rail, double now) {
  Keyframe key = pose_at(rail.path, rail.time);
  key.time = now;
  key.translate += rail.offset;
  return key;
}

void RailsControl::lead(Simulation& simulation, double now, double time_step) {
  for (std::size_t m = 0; m < rails_.size(); ++m) {
    Rail& rail = rails_[m];
    if (!rail.touched) continue;
    const Keyframe begin = pose(rail, now);
    const double most = fastest_path * time_step;
    rail.time += rail.held ? std::clamp(rail.wanted_time - rail.time, -most, most) : time_step;
    const Vec3 way = rail.wanted_offset - rail.offset;
    const double distance = length(way);
    rail.offset =
        distance > longest_step_ ? rail.offset + (longest_step_ / distance) * way : rail.wanted_offset;
    const Keyframe end = pose(rail, now + time_step);
    simulation.set_motion(static_cast<Index>(m), {rail.path.center, {begin, end}});
  }
}

void RailsControl::reset() {
  for (Rail& rail : rails_) rail = {std::move(rail.path)};
}

bool RailsControl::holds() const {
  return std::ranges::any_of(rails_, &Rail::held);
}

nlohmann::ordered_json RailsControl::json(double now) const {
  auto list = nlohmann::ordered_json::array();
  for (const Rail& rail : rails_) {
    list.push_back({{"time", rail.touched ? rail.time : now},
                    {"offset", {rail.offset.x, rail.offset.y, rail.offset.z}},
                    {"held", rail.held}});
  }
  return list;
}

}  // namespace palpate::view

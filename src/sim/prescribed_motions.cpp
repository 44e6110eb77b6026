#include "sim/prescribed_motions.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/rotation.hpp"
#include "number_text.hpp"

namespace palpate {
namespace {

constexpr std::size_t motion_grain = 1024;

struct MotionPose {
  Quaternion rotation;
  Vec3 translate;
};

MotionPose pose(const Motion& motion, double time) {
  const auto& keys = motion.keyframes;
  const auto next = std::upper_bound(keys.begin(), keys.end(), time,
                                     [](double t, const Keyframe& key) { return t < key.time; });
  if (next == keys.begin()) return {quaternion_of(next->quaternion), next->translate};
  const Keyframe& a = *(next - 1);
  if (next == keys.end()) return {quaternion_of(a.quaternion), a.translate};
  const Keyframe& b = *next;
  double fraction = (time - a.time) / (b.time - a.time);
  if (motion.interpolation == Interpolation::smooth) fraction = fraction * fraction * (3.0 - 2.0 * fraction);
  return {between(quaternion_of(a.quaternion), quaternion_of(b.quaternion), fraction),
          (1.0 - fraction) * a.translate + fraction * b.translate};
}

/// The name of an item in messages: "NAME[i]".
std::string element(std::string name, std::size_t i) {
  return name.append(1, '[').append(std::to_string(i)).append(1, ']');
}

void check_keyframe(const Motion& motion, std::size_t k, const std::string& where) {
  const Keyframe& key = motion.keyframes[k];
  const auto [w, x, y, z] = key.quaternion;
  if (!std::isfinite(key.time) || !is_finite(key.translate) || !std::isfinite(w + x + y + z) ||
      (w == 0.0 && x == 0.0 && y == 0.0 && z == 0.0)) {
    throw Error("motions", where, "a number that is not finite, or a zero quaternion",
                "finite numbers and a quaternion that is not zero");
  }
  if (k > 0 && key.time <= motion.keyframes[k - 1].time) {
    throw Error("motions", where + ".time", number_text(key.time),
                "more than the time before, " + number_text(motion.keyframes[k - 1].time));
  }
}

void check_motion(const Motion& motion, const std::string& where) {
  if (motion.keyframes.empty()) throw Error("motions", where, "no keyframe", "one or more keyframes");
  if (!is_finite(motion.center)) {
    throw Error("motions", where + ".center", "a number that is not finite", "three finite numbers");
  }
  for (std::size_t k = 0; k < motion.keyframes.size(); ++k) {
    check_keyframe(motion, k, element(where + ".keyframes", k));
  }
}

}  // namespace

Keyframe pose_at(const Motion& motion, double time) {
  check_motion(motion, "");
  const auto [rotation, translate] = pose(motion, time);
  return {time, translate, {rotation.scalar, rotation.vector.x, rotation.vector.y, rotation.vector.z}};
}

PrescribedMotions::PrescribedMotions(std::vector<Motion> motions, std::span<const Index> motion_of_point,
                                     std::span<const Vec3> start)
    : motions_(std::move(motions)) {
  for (std::size_t m = 0; m < motions_.size(); ++m) check_motion(motions_[m], element("", m));
  if (!motion_of_point.empty() && motion_of_point.size() != start.size()) {
    throw Error("motions", "motion_of_point", std::to_string(motion_of_point.size()) + " values",
                std::to_string(start.size()) + ", one for each point");
  }
  for (std::size_t p = 0; p < motion_of_point.size(); ++p) {
    const Index motion = motion_of_point[p];
    if (motion < 0) continue;
    if (static_cast<std::size_t>(motion) >= motions_.size()) {
      throw Error("motions", element("motion_of_point", p), std::to_string(motion),
                  "less than " + std::to_string(motions_.size()) + ", or -1");
    }
    points_.push_back(static_cast<Index>(p));
    motion_.push_back(motion);
    start_.push_back(start[p]);
  }
  positions_.resize(points_.size());
  moves_points_.resize(motions_.size(), 0);
  for (const Index motion : motion_) at(moves_points_, motion) = 1;
}

std::span<const Vec3> PrescribedMotions::positions(const parallel::Threads& threads, double time) {
  // There are few motions and many points. The loop over points computes the poses again for each chunk,
  // which is cheaper than a table.
  parallel::for_chunks(
      threads, points_.size(), motion_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        Index last = -1;
        MotionPose here{};
        for (std::size_t i = begin; i < end; ++i) {
          const Motion& motion = at(motions_, motion_[i]);
          if (motion_[i] != last) here = pose(motion, time);
          last = motion_[i];
          positions_[i] = motion.center + rotated(here.rotation, start_[i] - motion.center) + here.translate;
        }
      });
  return positions_;
}

std::vector<Vec3> PrescribedMotions::start_positions(const parallel::Threads& threads,
                                                     std::span<const Vec3> points_rest) {
  std::vector<Vec3> all(points_rest.begin(), points_rest.end());
  const std::span<const Vec3> placed = positions(threads, 0.0);
  for (std::size_t k = 0; k < placed.size(); ++k) at(all, points_[k]) = placed[k];
  return all;
}

void PrescribedMotions::replace(Index number, Motion motion) {
  if (number < 0 || static_cast<std::size_t>(number) >= motions_.size()) {
    throw Error("motions", "number", std::to_string(number), "less than " + std::to_string(motions_.size()));
  }
  check_motion(motion, element("", static_cast<std::size_t>(number)));
  at(motions_, number) = std::move(motion);
}

void PrescribedMotions::set_motions(std::vector<Motion> motions) {
  if (motions.size() != motions_.size()) {
    throw Error("motions", "", std::to_string(motions.size()) + " motions", std::to_string(motions_.size()));
  }
  for (std::size_t m = 0; m < motions.size(); ++m) check_motion(motions[m], element("", m));
  motions_ = std::move(motions);
}

double PrescribedMotions::end() const {
  double last = 0.0;
  for (std::size_t m = 0; m < motions_.size(); ++m) {
    if (moves_points_[m] != 0) last = std::max(last, motions_[m].keyframes.back().time);
  }
  return last;
}

}  // namespace palpate

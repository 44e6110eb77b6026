#include "sim/grabs.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "number_text.hpp"

namespace palpate {

void Grabs::check(Index number) const {
  const bool held =
      number >= 0 && static_cast<std::size_t>(number) < held_.size() && at(held_, number).grab.point >= 0;
  if (!held) throw Error("grab", "number", std::to_string(number), "the number of an active grab");
}

void Grabs::check_target(const Vec3& target) {
  if (!is_finite(target))
    throw Error("grab", "target", "a number that is not finite", "three finite numbers");
}

Index Grabs::add(const Grab& grab) {
  if (grab.point < 0 || grab.point >= point_count_) {
    std::string expected = "a point index in [0, ";
    expected.append(std::to_string(point_count_ - 1)).append(1, ']');
    throw Error("grab", "point", std::to_string(grab.point), expected);
  }
  if (!(grab.stiffness > 0.0) || !std::isfinite(grab.stiffness)) {
    throw Error("grab", "stiffness", number_text(grab.stiffness), "a finite number > 0");
  }
  check_target(grab.target);
  const auto unused =
      std::find_if(held_.begin(), held_.end(), [](const HeldGrab& h) { return h.grab.point < 0; });
  const auto number = static_cast<Index>(unused - held_.begin());
  if (unused == held_.end()) held_.emplace_back();
  at(held_, number) = {grab};
  return number;
}

void Grabs::move(Index number, const Vec3& target) {
  check(number);
  check_target(target);
  at(held_, number).grab.target = target;
}

void Grabs::release(Index number) {
  check(number);
  at(held_, number) = {};
}

const HeldGrab& Grabs::held(Index number) const {
  check(number);
  return at(held_, number);
}

void Grabs::append(std::span<const Vec3> positions, std::span<const double> masses,
                   std::vector<fem::Coupling>& couplings) const {
  for (const HeldGrab& held : held_) {
    const auto& [point, target, k] = held.grab;
    if (point < 0) continue;
    const double damping = 2.0 * std::sqrt(k * at(masses, point));
    fem::Coupling coupling;
    coupling.points[0] = point;
    coupling.coefficients[0] = 1.0;
    coupling.force = k * (target - at(positions, point));
    coupling.stiffness = {k, k, k, 0.0, 0.0, 0.0};
    coupling.damping = {damping, damping, damping, 0.0, 0.0, 0.0};
    couplings.push_back(coupling);
  }
}

void Grabs::collect_forces(std::span<const fem::Coupling> couplings, double time_step,
                           std::span<const Vec3> velocities_end) {
  std::size_t next = 0;
  for (HeldGrab& held : held_) {
    if (held.grab.point >= 0) held.force = fem::end_force(couplings[next++], time_step, velocities_end);
  }
}

}  // namespace palpate

#include "disturbances.hpp"

#include "geometry/vector.hpp"

namespace palpate::bench {

double Random::uniform(double low, double high) {
  state_ += 0x9e3779b97f4a7c15U;
  std::uint64_t z = state_;
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return low + (high - low) * static_cast<double>((z ^ (z >> 31U)) >> 11U) * 0x1p-53;
}

Vec3 Random::in_ball(double radius) {
  const auto side = [&] { return uniform(-radius, radius); };
  return {side(), side(), side()};
}

Disturbances::Disturbances(const Simulation& simulation, std::vector<Motion> motions,
                           std::span<const std::uint8_t> rigid, std::uint64_t seed)
    : random_(seed), motions_(std::move(motions)) {
  const Bodies& bodies = simulation.bodies();
  edge_ = mesh_statistics(bodies, bodies.points_rest()).edge_length.mean;
  for (Index b = 0; b < bodies.body_count(); ++b) {
    if (at(rigid, b) != 0) continue;
    const Range points = at(bodies.bodies(), b).points;
    const double h = simulation.settings().time_step;
    soft_.push_back({points, at(simulation.masses(), b) / static_cast<double>(points.size()) / (h * h)});
  }
  for (const Motion& motion : motions_) poses_.push_back(pose_at(motion, 0.0));
}

void Disturbances::apply(Simulation& simulation, std::span<Simulation> others) {
  const std::int64_t step = simulation.metrics().step;
  if (step % 5 == 0) push(simulation);
  if (step % 200 == 50) hold(simulation);
  if (grab_ >= 0 && step % 10 == 0) simulation.move_grab(grab_, home_ + random_.in_ball(2.0 * edge_));
  if (grab_ >= 0 && step % 200 == 150) {
    simulation.release(grab_);
    grab_ = -1;
  }
  if (step % 100 == 0) redirect(simulation, others);
}

/// A force that moves a free point by a tenth of an edge in a step.
void Disturbances::push(Simulation& simulation) {
  if (pushed_ >= 0) simulation.set_force(pushed_, {});
  const auto [point, inertia] = any_point();
  pushed_ = point;
  simulation.set_force(pushed_, random_.in_ball(0.1 * edge_ * inertia));
}

/// A grab with the stiffness of inertia over a step.
void Disturbances::hold(Simulation& simulation) {
  const auto [point, inertia] = any_point();
  home_ = at(simulation.positions(), point);
  grab_ = simulation.grab({.point = point, .target = home_, .stiffness = inertia});
}

/// Moves prescribed bodies, in 80 steps, to a position near another point of their path.
void Disturbances::redirect(Simulation& simulation, std::span<Simulation> others) {
  const double now = simulation.metrics().time;
  for (std::size_t m = 0; m < motions_.size(); ++m) {
    Keyframe begin = poses_[m];
    Keyframe end = pose_at(motions_[m], random_.uniform(0.0, motions_[m].keyframes.back().time));
    end.translate += random_.in_ball(0.2 * edge_);
    begin.time = now;
    end.time = now + 80.0 * simulation.settings().time_step;
    const Motion segment{motions_[m].center, {begin, end}, Interpolation::smooth};
    simulation.set_motion(static_cast<Index>(m), segment);
    for (Simulation& other : others) other.set_motion(static_cast<Index>(m), segment);
    poses_[m] = end;
  }
}

std::pair<Index, double> Disturbances::any_point() {
  const auto below = [&](std::size_t count) {
    return static_cast<std::size_t>(random_.uniform(0.0, 0.999999 * static_cast<double>(count)));
  };
  const Soft& body = soft_[below(soft_.size())];
  const auto offset = static_cast<Index>(below(static_cast<std::size_t>(body.points.size())));
  return {body.points.begin + offset, body.inertia};
}

}  // namespace palpate::bench

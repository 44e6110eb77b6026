#include "body_forces.hpp"

#include <algorithm>

#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

void add(const Wrench& more, double sign, Wrench& sum) {
  const Wrench here = moved_to(more, sum.about);
  sum.force += sign * here.force;
  sum.torque += sign * here.torque;
}

}  // namespace

ForceProbe::ForceProbe(const Scene& scene, const Model& model)
    : held_(scene.bodies.size(), 0), motions_(scene.bodies.size(), -1) {
  Index motion = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    names_.push_back(scene.bodies[b].name);
    if (scene.bodies[b].motion) motions_[b] = motion++;
  }
  for (std::size_t p = 0; p < model.fixed_points.size(); ++p) {
    if (model.fixed_points[p] != 0 || model.motion_of_point[p] >= 0)
      at(held_, model.bodies.body_of_point()[p]) = 1;
  }
  const auto index = [&](const std::string& name) {
    return static_cast<Index>(std::ranges::find(names_, name) - names_.begin());
  };
  for (const BodyPair& pair : scene.output.pairs)
    pairs_.push_back({index(pair.bodies.names[0]), index(pair.bodies.names[1])});
}

std::vector<BodyForces> ForceProbe::forces(const Simulation& simulation) const {
  std::vector<BodyForces> all(names_.size());
  for (std::size_t b = 0; b < all.size(); ++b)
    all[b].contact.about = simulation.center_of_mass(static_cast<Index>(b));
  for (const PairWrench& pair : simulation.pair_wrenches()) {
    if (pair.body_a == pair.body_b) continue;
    add(pair.on_b, 1.0, at(all, pair.body_b).contact);
    add(pair.on_b, -1.0, at(all, pair.body_a).contact);
  }
  for (std::size_t b = 0; b < all.size(); ++b) {
    if (held_[b] == 0) continue;
    const Vec3& center = all[b].contact.about;
    if (simulation.metrics().step == 0) {
      all[b].held = Wrench{.force = {}, .torque = {}, .about = center};
    } else if (motions_[b] >= 0) {
      all[b].held = simulation.reaction_of_motion(motions_[b], center);
    } else {
      all[b].held = simulation.reaction_of_body(static_cast<Index>(b), center);
    }
  }
  return all;
}

std::vector<PairWrench> ForceProbe::pair_forces(const Simulation& simulation) const {
  if (pairs_.empty()) return {};
  const std::vector<PairWrench> there = simulation.pair_wrenches();
  std::vector<PairWrench> wanted;
  for (const auto& [first, second] : pairs_) {
    PairWrench pair{.body_a = first, .body_b = second};
    pair.on_b.about = simulation.center_of_mass(second);
    for (const PairWrench& other : there) {
      const bool same = other.body_a == first && other.body_b == second;
      const bool reverse = other.body_a == second && other.body_b == first;
      if (!same && !reverse) continue;
      pair.contacts = other.contacts;
      pair.normal = other.normal;
      add(other.on_b, same ? 1.0 : -1.0, pair.on_b);
    }
    wanted.push_back(pair);
  }
  return wanted;
}

}  // namespace palpate::app

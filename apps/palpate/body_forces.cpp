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
    : held_(scene.bodies.size(), 0),
      tied_(scene.bodies.size(), 0),
      grabbed_(scene.bodies.size(), 0),
      motions_(scene.bodies.size(), -1) {
  Index motion = 0;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    names_.push_back(scene.bodies[b].name);
    if (scene.bodies[b].motion) motions_[b] = motion++;
  }
  for (std::size_t p = 0; p < model.fixed_points.size(); ++p) {
    if (model.fixed_points[p] != 0 || model.motion_of_point[p] >= 0)
      at(held_, model.bodies.body_of_point()[p]) = 1;
  }
  for (std::size_t p = 0; p < model.fixed_axes.size(); ++p) {
    if (model.fixed_axes[p] != 0) at(held_, model.bodies.body_of_point()[p]) = 1;
  }
  const auto index = [&](const std::string& name) {
    return static_cast<Index>(std::ranges::find(names_, name) - names_.begin());
  };
  for (const Tie& tie : model.ties) {
    at(tied_, at(model.bodies.body_of_point(), tie.point)) = 1;
    at(tied_, model.bodies.body_of(at(model.bodies.tets(), tie.tet))) = 1;
  }
  for (const Stage& stage : scene.stages) {
    for (const StageTie& tie : stage.tie) at(tied_, index(tie.body)) = at(tied_, index(tie.to)) = 1;
  }
  for (const Grab& grab : model.grabs) at(grabbed_, at(model.bodies.body_of_point(), grab.point)) = 1;
  for (const BodyPair& pair : scene.output.pairs)
    pairs_.push_back({index(pair.bodies.names[0]), index(pair.bodies.names[1])});
}

void ForceProbe::add_contacts(const std::vector<PairWrench>& touching, ForcesOfStep& all) const {
  for (const PairWrench& pair : touching) {
    all.normal += pair.normal;
    if (pair.body_a == pair.body_b) continue;
    add(pair.on_b, 1.0, at(all.bodies, pair.body_b).contact);
    add(pair.on_b, -1.0, at(all.bodies, pair.body_a).contact);
  }
  for (const BodyForces& body : all.bodies) all.largest = std::max(all.largest, length(body.contact.force));
}

void ForceProbe::add_held(const Simulation& simulation, ForcesOfStep& all) const {
  for (std::size_t b = 0; b < all.bodies.size(); ++b) {
    if (held_[b] == 0) continue;
    const Vec3& center = all.bodies[b].contact.about;
    if (simulation.metrics().step == 0) {
      all.bodies[b].held = Wrench{.force = {}, .torque = {}, .about = center};
    } else if (motions_[b] >= 0) {
      all.bodies[b].held = simulation.reaction_of_motion(motions_[b], center);
    } else {
      all.bodies[b].held = simulation.reaction_of_body(static_cast<Index>(b), center);
    }
  }
}

PairWrench ForceProbe::force_of(const Pair& named, const std::vector<PairWrench>& touching,
                                const Vec3& center) const {
  PairWrench pair{.body_a = named.first, .body_b = named.second};
  pair.on_b.about = center;
  for (const PairWrench& other : touching) {
    const bool same = other.body_a == named.first && other.body_b == named.second;
    const bool reverse = other.body_a == named.second && other.body_b == named.first;
    if (!same && !reverse) continue;
    pair.contacts = other.contacts;
    pair.normal = other.normal;
    add(other.on_b, same ? 1.0 : -1.0, pair.on_b);
  }
  return pair;
}

ForcesOfStep ForceProbe::forces(const Simulation& simulation) const {
  ForcesOfStep all;
  all.bodies.resize(names_.size());
  for (std::size_t b = 0; b < all.bodies.size(); ++b) {
    const auto body = static_cast<Index>(b);
    const Vec3 center = simulation.center_of_mass(body);
    all.bodies[b].contact.about = center;
    if (is_tied(b)) all.bodies[b].tied = simulation.tie_wrench(body, center);
    if (is_grabbed(b)) all.bodies[b].grabbed = simulation.grab_wrench(body, center);
  }
  const std::vector<PairWrench> touching = simulation.pair_wrenches();
  add_contacts(touching, all);
  add_held(simulation, all);
  for (const Pair& pair : pairs_)
    all.pairs.push_back(force_of(pair, touching, at(all.bodies, pair.second).contact.about));
  return all;
}

}  // namespace palpate::app

#include "simulation.hpp"

#include <algorithm>
#include <nanobind/nanobind.h>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "world.hpp"

namespace palpate::python {
namespace {

/// Lets a waiting Ctrl-C end what runs without Python's lock.
void check_signals() {
  const nanobind::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

}  // namespace

Simulation::Simulation(const Model& model, const Scene& scene, int threads)
    : turned_(model.turned()), self_collision_(model.self_collision()) {
  palpate::Model data = model.data();
  for (const Body& body : data.bodies.bodies()) {
    const bool has = !data.motion_of_point.empty() && body.points.size() > 0;
    const bool rigid = at(data.obstacles, motion_of_body_.size()) != 0;
    motion_of_body_.push_back(has && rigid ? at(data.motion_of_point, body.points.begin) : -1);
  }
  on_rails_.resize(data.bodies.points_rest().size());
  for (std::size_t p = 0; p < data.motion_of_point.size(); ++p) on_rails_[p] = data.motion_of_point[p] >= 0;
  SimulationSettings settings = scene.settings;
  settings.detection.self_collision = model.self_collision();
  const nanobind::gil_scoped_release release;
  if (scene.relax)
    relaxed_ = relax(data, settings, *scene.relax, threads, [](int, double) { check_signals(); });
  simulation_ = std::make_unique<palpate::Simulation>(std::move(data), settings, threads);
}

void Simulation::step() {
  const Busy::Use use(busy_, "Simulation.step");
  {
    const nanobind::gil_scoped_release release;
    simulation_->step();
  }
  const StepMetrics& metrics = simulation_->metrics();
  if (!metrics.solver_converged) ++steps_not_converged_;
  most_inverted_tets_ = std::max(most_inverted_tets_, metrics.inverted_tets);
  contacts_.reset();
  crossings_.reset();
}

void Simulation::restore(std::span<const std::byte> saved) {
  const Busy::Use use(busy_, "Simulation.restore");
  {
    const nanobind::gil_scoped_release release;
    simulation_->restore(saved);
  }
  contacts_.reset();
  crossings_.reset();
}

ContactForces Simulation::acting_contacts() {
  ContactForces forces = idle().acting_contacts();
  for (std::size_t c = 0; c < forces.size(); ++c) {
    if (forces.tet[c] >= 0 && at(turned_, forces.tet[c]) != 0)
      std::swap(forces.weights[c][2], forces.weights[c][3]);
  }
  return forces;
}

TissueState Simulation::tissue(bool at_points) {
  const Busy::Use use(busy_, "Simulation.tissue");
  const nanobind::gil_scoped_release release;
  return at_points ? simulation_->tissue_at_points() : simulation_->tissue();
}

Index Simulation::motion_of(Index body) const {
  const auto count = static_cast<Index>(motion_of_body_.size());
  if (body < 0 || body >= count)
    throw Error("Simulation", "body", std::to_string(body), "0 to " + std::to_string(count - 1));
  const Index motion = at(motion_of_body_, body);
  if (motion < 0) {
    throw Error("Simulation", "body", std::to_string(body) + ", which has no motion",
                "a body that was given one");
  }
  return motion;
}

void Simulation::change(const Scene& scene) {
  SimulationSettings settings = scene.settings;
  settings.detection.self_collision = self_collision_;
  idle().change(settings);
  contacts_.reset();
  crossings_.reset();
}

void Simulation::set_positions(std::span<const Index> points, std::span<const Vec3> positions) {
  idle().set_positions(points, positions);
  contacts_.reset();
  crossings_.reset();
}

std::shared_ptr<const Contacts> Simulation::contacts() {
  if (!contacts_) {
    contacts_ = std::make_shared<Contacts>(idle().detector().contacts());
    order_weights_as_given(*contacts_, turned_);
  }
  return contacts_;
}

std::shared_ptr<const Crossings> Simulation::crossings() {
  if (!crossings_) crossings_ = std::make_shared<Crossings>(crossings_of(idle().detector()));
  return crossings_;
}

EdgeContacts Simulation::edge_contacts() {
  return idle().detector().edge_contacts();
}

}  // namespace palpate::python

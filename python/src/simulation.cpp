#include "simulation.hpp"

#include <algorithm>
#include <nanobind/nanobind.h>
#include <utility>

#include "world.hpp"

namespace palpate::python {
namespace {

/// Lets a waiting Ctrl-C end what runs without Python's lock.
void check_signals() {
  const nanobind::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

}  // namespace

Simulation::Simulation(const Model& model, const Scene& scene, int threads) : turned_(model.turned()) {
  palpate::Model data = model.data();
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

}  // namespace palpate::python

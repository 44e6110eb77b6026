#include "simulation.hpp"

#include <algorithm>
#include <nanobind/nanobind.h>
#include <set>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/near.hpp"
#include "scene/stage_archive.hpp"
#include "sim/unseen_passes.hpp"
#include "world.hpp"

namespace palpate::python {
namespace {

/// Lets a pending Ctrl-C end work that runs without Python's lock.
void check_signals() {
  const nanobind::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
}

/// A saved simulation with its progress through stages.
struct Parted {
  std::span<const std::byte> simulation;
  StageProgress progress;
  std::vector<std::vector<OutcomeValue>> outcomes;
};

/// Splits the bytes of save() of a simulation with stages.
Parted parted(std::span<const std::byte> saved) {
  std::uint64_t size = 0;
  if (saved.size() < sizeof size) throw Error("saved state", "", "too few bytes", "what save() returned");
  ArchiveReader last(saved.last(sizeof size), "saved state");
  last(size);
  if (size > saved.size()) {
    throw Error("saved state", "", "the state of a simulation without stages",
                "the state of a simulation with stages");
  }
  Parted parts{saved.first(size), {}, {}};
  ArchiveReader reader(saved.subspan(size), "saved state");
  reader(parts.progress, parts.outcomes, size);
  reader.finish();
  return parts;
}

/// The arrays of the last call, empty where Python still has them. Call it with Python's lock.
TissueState dropped(const std::shared_ptr<TissueState>& last) {
  return last && last.use_count() == 1 ? std::move(*last) : TissueState{};
}

}  // namespace

Simulation::Simulation(const Model& model, const Scene& scene, int threads)
    : reoriented_(model.reoriented()),
      self_collision_(model.self_collision()),
      units_(model.units().value_or(scene.units)) {
  palpate::Model data = model.data();
  for (const Body& body : data.bodies.bodies()) {
    const bool has = !data.motion_of_point.empty() && body.points.size() > 0;
    const bool rigid = at(data.obstacles, motion_of_body_.size()) != 0;
    motion_of_body_.push_back(has && rigid ? at(data.motion_of_point, body.points.begin) : -1);
  }
  prescribed_.resize(data.bodies.points_rest().size());
  for (std::size_t p = 0; p < data.motion_of_point.size(); ++p) prescribed_[p] = data.motion_of_point[p] >= 0;
  SimulationSettings settings = scene.settings;
  settings.detection.self_collision = model.self_collision();
  const nanobind::gil_scoped_release release;
  if (scene.relax)
    relaxed_ = relax(data, settings, *scene.relax, threads, [](int, double) { check_signals(); });
  simulation_ = std::make_unique<palpate::Simulation>(std::move(data), settings, threads);
  outcomes_ = std::make_unique<OutcomeProbe>(scene, simulation_->bodies());
  stages_ = std::make_unique<StageRun>(scene, *simulation_);
}

void Simulation::step() {
  const Busy::Use use(busy_, "Simulation.step");
  {
    const nanobind::gil_scoped_release release;
    stages_->begin(*simulation_);
    if (stages_->any()) follow_holds();
    simulation_->step();
    if (stages_->ends(*simulation_)) stage_outcomes_.push_back(outcomes_->values(*simulation_));
  }
  const StepMetrics& metrics = simulation_->metrics();
  if (!metrics.solver_converged) ++steps_not_converged_;
  if (may_have_passed(metrics, simulation_->settings().detection.continuous)) ++steps_too_far_;
  most_inverted_tets_ = std::max(most_inverted_tets_, metrics.inverted_tets);
  contacts_.reset();
  crossings_.reset();
}

void Simulation::change(const ModelChange& change) {
  idle().change(change);
  follow_holds();
  contacts_.reset();
  crossings_.reset();
}

Index Simulation::move(std::vector<Index> points, Motion motion) {
  change({.moves = {{std::move(points), std::move(motion)}}});
  return simulation_->motion_count() - 1;
}

void Simulation::tie(const std::vector<Index>& points, Index to, std::optional<double> stiffness) {
  const Bodies& bodies = idle().bodies();
  const std::span<const Vec3> positions = simulation_->positions();
  ModelChange ties;
  for (const Index p : points) {
    if (p < 0 || static_cast<std::size_t>(p) >= positions.size()) {
      throw Error("Simulation.tie", "points", std::to_string(p),
                  "less than " + std::to_string(positions.size()));
    }
    ties.ties.push_back({p, nearest_tet(bodies, positions, to, at(positions, p)), stiffness});
  }
  change(ties);
}

Index Simulation::untie(Index a, Index b) {
  const Bodies& bodies = idle().bodies();
  const std::vector<Tie> ties = simulation_->ties();
  ModelChange cut;
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const Index from = at(bodies.body_of_point(), ties[t].point);
    const Index to = bodies.body_of(at(bodies.tets(), ties[t].tet));
    if ((from == a && to == b) || (from == b && to == a)) cut.untie.push_back(static_cast<Index>(t));
  }
  if (!cut.untie.empty()) change(cut);
  return static_cast<Index>(cut.untie.size());
}

/// Updates Python's record of motions.
void Simulation::follow_holds() {
  const std::span<const Index> motions = simulation_->motion_of_points();
  for (std::size_t p = 0; p < motions.size(); ++p) prescribed_[p] = motions[p] >= 0;
  for (std::size_t b = 0; b < motion_of_body_.size(); ++b) {
    const Range points = simulation_->bodies().bodies()[b].points;
    const auto own =
        motions.subspan(static_cast<std::size_t>(points.begin), static_cast<std::size_t>(points.size()));
    const bool one = !own.empty() && std::ranges::count(own, own.front()) == std::ssize(own);
    motion_of_body_[b] = one ? own.front() : -1;
  }
}

std::vector<std::byte> Simulation::save() {
  std::vector<std::byte> saved = idle().save();
  if (!stages_->any()) return saved;
  StageProgress progress = stages_->progress();
  std::uint64_t size = saved.size();
  ArchiveWriter writer;
  writer(progress, stage_outcomes_, size);
  const std::vector<std::byte> more = writer.take();
  saved.insert(saved.end(), more.begin(), more.end());
  return saved;
}

void Simulation::restore(std::span<const std::byte> saved) {
  const Busy::Use use(busy_, "Simulation.restore");
  {
    const nanobind::gil_scoped_release release;
    auto [simulation, progress, outcomes] = stages_->any() ? parted(saved) : Parted{saved, {}, {}};
    simulation_->restore(simulation);
    if (stages_->any()) stages_->resume(*simulation_, std::move(progress));
    stage_outcomes_ = std::move(outcomes);
    follow_holds();
  }
  contacts_.reset();
  crossings_.reset();
}

ContactForces Simulation::acting_contacts() {
  ContactForces forces = idle().acting_contacts();
  for (std::size_t c = 0; c < forces.size(); ++c) {
    if (forces.tet[c] >= 0 && at(reoriented_, forces.tet[c]) != 0)
      std::swap(forces.weights[c][2], forces.weights[c][3]);
  }
  return forces;
}

std::shared_ptr<TissueState> Simulation::tissue() {
  const Busy::Use use(busy_, "Simulation.tissue");
  TissueState memory = dropped(tissue_);
  const nanobind::gil_scoped_release release;
  return tissue_ = std::make_shared<TissueState>(simulation_->tissue(std::move(memory)));
}

std::shared_ptr<TissueState> Simulation::tissue_at_points(const TissueState* of_tets) {
  const Busy::Use use(busy_, "Simulation.tissue_at_points");
  TissueState memory = dropped(tissue_at_points_);
  const nanobind::gil_scoped_release release;
  return tissue_at_points_ = std::make_shared<TissueState>(
             of_tets == nullptr ? simulation_->tissue_at_points()
                                : simulation_->tissue_at_points(*of_tets, std::move(memory)));
}

std::vector<Index> Simulation::prescribed_of(Index body) {
  const std::span<const Index> motions = idle().motion_of_points();
  const Range points = at(simulation_->bodies().bodies(), body).points;
  std::set<Index> numbers;
  for (Index p = points.begin; p < points.end; ++p) numbers.insert(at(motions, p));
  for (const Index of_body : motion_of_body_) numbers.erase(of_body);
  numbers.erase(-1);
  return {numbers.begin(), numbers.end()};
}

void Simulation::check_prescribed(Index number) {
  const Index count = idle().motion_count();
  const auto body = std::ranges::find(motion_of_body_, number);
  if (number < 0 || number >= count || body != motion_of_body_.end()) {
    std::string found = std::to_string(number);
    if (number >= 0 && body != motion_of_body_.end()) {
      const auto b = static_cast<Index>(body - motion_of_body_.begin());
      found += ", the motion of the body '" + at(simulation_->bodies().bodies(), b).name + "'";
    }
    throw Error("Simulation", "number", found,
                "a number of bodies[...].prescribed, or what Model.prescribe() returned");
  }
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
    order_weights_as_given(*contacts_, reoriented_);
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

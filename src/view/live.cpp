#include "view/live.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "sim/unseen_passes.hpp"
#include "stopwatch.hpp"
#include "view/stored_stages.hpp"

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> mean_edge_lengths(const Bodies& bodies) {
  std::vector<double> lengths;
  lengths.reserve(bodies.bodies().size());
  for (Index b = 0; b < bodies.body_count(); ++b) {
    lengths.push_back(mesh_statistics(bodies, bodies.points_rest(), b).edge_length.mean);
  }
  return lengths;
}

Json names_json(std::span<const std::string_view> names) {
  Json list = Json::array();
  for (const std::string_view name : names) list.push_back(name);
  return list;
}

Json vector_json(const Vec3& v) {
  return {v.x, v.y, v.z};
}

/// The fields for colours on the page.
Json fields_json() {
  Json list = Json::array();
  for (const ColourField& field : colour_fields()) list.push_back(field_json(field));
  return list;
}

}  // namespace

LiveSource::LiveSource(const Scene& scene, Model model, int threads)
    : model_(std::move(model)),
      present_(model_),
      threads_(threads),
      simulation_(Model(model_), scene.settings, threads),
      all_stages_(scene, simulation_),
      stages_(all_stages_),
      surface_(simulation_.bodies()),
      edge_lengths_(mean_edge_lengths(simulation_.bodies())),
      movable_(movable_bodies(scene)),
      motions_(motions_at_start()),
      limits_(pull_limits()),
      stage_{about(scene), extent_of(simulation_.positions()).center} {
  begin_stage();
}

/// The rigid body of each motion (-1: none); then the others that stages move.
std::vector<Index> LiveSource::movable_bodies(const Scene& scene) const {
  std::vector<Index> movable;
  for (std::size_t m = 0; m < model_.motions.size(); ++m)
    movable.push_back(body_of_motion(static_cast<Index>(m)));
  for (const palpate::Stage& stage : scene.stages) {
    for (const StageMove& move : stage.move) {
      const auto of_scene = std::ranges::find(scene.bodies, move.body, &SceneBody::name);
      const auto body = static_cast<Index>(of_scene - scene.bodies.begin());
      const bool known = std::ranges::find(movable, body) != movable.end();
      if (!known && !move.part && is_rigid(*of_scene)) movable.push_back(body);
    }
  }
  return movable;
}

MotionControl LiveSource::motions_at_start() const {
  // A fifth of an edge per step, which tissue in contact can follow.
  MotionControl motions(model_.motions, 0.2 * *std::ranges::min_element(edge_lengths_));
  for (std::size_t m = model_.motions.size(); m < movable_.size(); ++m) motions.add_unmoved();
  return motions;
}

PullLimits LiveSource::pull_limits() const {
  return {present_, simulation_.contact_materials(), edge_lengths_, simulation_.settings().time_step};
}

Index LiveSource::body_of_motion(Index motion) const {
  for (Index b = 0; b < bodies().body_count(); ++b) {
    const Index first = at(bodies().bodies(), b).points.begin;
    const bool rigid = !model_.obstacles.empty() && at(model_.obstacles, b) != 0;
    if (rigid && !model_.motion_of_point.empty() && at(model_.motion_of_point, first) == motion) return b;
  }
  return -1;
}

Json LiveSource::motions_json() const {
  Json list = Json::array();
  for (const Index body : movable_) list.push_back({{"body", body}});
  return list;
}

Json LiveSource::about(const Scene& scene) const {
  Json json =
      about_json(scene, bodies_json(bodies(), surface_, scene), extent_of(bodies().points_rest()).diagonal);
  json["mode"] = "live";
  json["motions"] = motions_json();
  json["stages"] = stage_names_json(scene);
  json["fields"] = fields_json();
  json["typical_stiffness"] = typical_contact_stiffness();
  json["choices"] = {{"structure", names_json(structure_names)},
                     {"order", names_json(order_names)},
                     {"sort", names_json(sort_names)},
                     {"budget", {"none", "milliseconds"}}};
  return json;
}

void LiveSource::advance() {
  Stopwatch watch;
  motions_.lead(simulation_, time(), simulation_.settings().time_step);
  lead_pulls();
  simulation_.record_reactions(true);
  has_reactions_ = false;
  const StepMetrics& m = simulation_.step();
  const DetectionTimes& t = m.detection_seconds;
  seconds_ = {t.grid,  t.contacts,       t.border_edges,   t.crossings,
              t.depth, m.forces_seconds, m.solver_seconds, watch.lap()};
  has_reactions_ = true;
  if (!m.solver_converged) ++steps_not_converged_;
  most_inverted_tets_ = std::max(most_inverted_tets_, m.inverted_tets);
  count_passes(m);
  if (stages_.ends(simulation_)) begin_stage();
}

void LiveSource::count_passes(const StepMetrics& m) {
  if (!may_have_passed(m, simulation_.settings().detection.continuous)) return;
  thinnest_ = thinner(thinnest_, m.thinnest);
  ++steps_too_far_;
}

void LiveSource::reset() {
  SimulationSettings settings = simulation_.settings();
  settings.gravity = gravity_before_.value_or(settings.gravity);
  simulation_ = Simulation(Model(model_), settings, threads_);
  present_ = model_;
  stages_ = all_stages_;
  gravity_before_.reset();
  motions_ = motions_at_start();
  limits_ = pull_limits();
  pulls_.clear();
  has_reactions_ = false;
  seconds_ = {};
  steps_not_converged_ = 0;
  most_inverted_tets_ = 0;
  steps_too_far_ = 0;
  begin_stage();
}

Json LiveSource::counts() const {
  const StepMetrics& m = simulation_.metrics();
  Json json = detection_json(m.detection);
  json["step"] = m.step;
  json["kinetic_energy"] = m.kinetic_energy;
  json["elastic_energy"] = m.elastic_energy;
  json["largest_speed"] = m.largest_speed;
  json["deepest"] = m.deepest;
  json["solver_iterations"] = m.solver_iterations;
  json["steps_not_converged"] = steps_not_converged_;
  json["inverted_tets"] = {{"now", m.inverted_tets}, {"most", most_inverted_tets_}};
  json["too_far"] = {{"steps", steps_too_far_}, {"thinnest", thinnest_}};
  json["at_rest"] = simulation_.at_rest();
  json["pulls"] = pulls_json();
  json["driven"] = driven_motions_json();
  if (stages_.any()) json["plan"] = stages_json();
  return json;
}

Json LiveSource::pulls_json() const {
  Json list = Json::array();
  for (const auto& [client, held] : pulls_) {
    list.push_back({{"client", client},
                    {"vertex", held.vertex},
                    {"target", vector_json(held.target - stage_.origin)},
                    {"force", vector_json(simulation_.grab_force(held.grab))},
                    {"most", held.most}});
  }
  return list;
}

/// Contact forces, and reactions of prescribed bodies.
Json LiveSource::forces() const {
  Json list = wrenches_json(simulation_);
  for (std::size_t m = 0; m < movable_.size() && has_reactions_; ++m) {
    const Index body = movable_[m];
    const Index number = motions_.number(m);
    if (body < 0 || number < 0) continue;
    const Wrench motor = simulation_.reaction_of_motion(number, simulation_.center_of_mass(body));
    list[static_cast<std::size_t>(body)]["held"] = wrench_json(motor);
  }
  return list;
}

/// The state of prescribed motions; with the force of the motor for those moved by hand.
Json LiveSource::driven_motions_json() const {
  Json list = motions_.json(time());
  if (!has_reactions_) return list;
  for (std::size_t m = 0; m < list.size(); ++m) {
    if (!list[m]["held"]) continue;
    list[m]["force"] = vector_json(simulation_.reaction_of_motion(motions_.number(m), {}).force);
  }
  return list;
}

Index LiveSource::spring(const Held& held) {
  const Index point = at(surface_.points(), held.vertex);
  const double stiffness =
      limited_stiffness({held.stiffness, limits_.mass(point), held.most}, at(positions(), point),
                        at(simulation_.velocities(), point), simulation_.settings().time_step, held.target);
  return simulation_.grab({point, held.target, stiffness});
}

/// Limits the force of pulls, so that a hand that is far away does not destroy the tissue.
void LiveSource::lead_pulls() {
  for (auto& [client, held] : pulls_) {
    simulation_.release(held.grab);
    held.grab = spring(held);
  }
}

/// N/m: approximate stiffness of one layer of tets of the body.
double LiveSource::usual_stiffness(Index body) const {
  return at(simulation_.contact_materials(), body).young_modulus * at(edge_lengths_, body);
}

/// A typical automatic contact stiffness of these bodies (ContactResponse::stiffness()), as an initial value.
double LiveSource::typical_contact_stiffness() const {
  double softest = 0.0;
  for (Index b = 0; b < bodies().body_count(); ++b) {
    if (!model_.obstacles.empty() && at(model_.obstacles, b) != 0) continue;
    const double k = 5.0 * usual_stiffness(b);
    softest = softest == 0.0 ? k : std::min(softest, k);
  }
  return softest;
}

bool LiveSource::is_free(Index point) const {
  const bool fixed = !present_.fixed_points.empty() && at(present_.fixed_points, point) != 0;
  const Index body = at(bodies().body_of_point(), point);
  return !fixed && at(simulation_.motion_of_points(), point) < 0 && !simulation_.is_rigid(body) &&
         simulation_.is_present(body);
}

void LiveSource::apply(Client /*client*/, const Change& change) {
  simulation_.change(changed(simulation_.settings(), change.settings));
}

void LiveSource::apply(Client client, const Pull& pull) {
  if (pull.vertex < 0 || pull.vertex >= surface_.vertex_count()) {
    throw Error("message from the page", "pull.vertex", std::to_string(pull.vertex),
                "less than " + std::to_string(surface_.vertex_count()));
  }
  const Index point = at(surface_.points(), pull.vertex);
  if (!is_free(point)) {
    throw Error("pull", "", "a point that is fixed, rigid or prescribed",
                "a point of soft tissue that can move");
  }
  const Vec3 target = stage_.origin + pull.target;
  const double stiffness = pull.strength * usual_stiffness(at(bodies().body_of_point(), point));
  Held held{.vertex = pull.vertex, .target = target, .stiffness = stiffness, .most = limits_.force(point)};
  held.grab = spring(held);
  forget(client);
  pulls_[client] = held;
}

void LiveSource::apply(Client client, const MovePull& pull) {
  const auto held = pulls_.find(client);
  if (held == pulls_.end()) return;  // a reset has removed it
  const Vec3 target = stage_.origin + pull.target;
  simulation_.move_grab(held->second.grab, target);  // throws Error for coordinates that are not finite
  held->second.target = target;
}

void LiveSource::apply(Client client, const LetGo& /*pull*/) {
  forget(client);
}

void LiveSource::apply(Client /*client*/, const DriveMotion& command) {
  motions_.move(command, time());
}

void LiveSource::apply(Client /*client*/, const ResumeMotion& command) {
  motions_.run(command, time());
}

void LiveSource::apply(Client /*client*/, const Seek& /*seek*/) {
  throw Error("seek", "", "a running simulation",
              "stored results: the time of a running simulation only increases");
}

void LiveSource::forget(Client client) {
  const auto held = pulls_.find(client);
  if (held == pulls_.end()) return;
  simulation_.release(held->second.grab);
  pulls_.erase(held);
}

}  // namespace palpate::view

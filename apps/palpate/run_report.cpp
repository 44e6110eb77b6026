#include "run_report.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <string_view>

#include <palpate/version.hpp>

#include "body_report.hpp"
#include "displacement.hpp"
#include "geometry/vector.hpp"
#include "io/machine.hpp"
#include "numbers.hpp"
#include "outcomes_json.hpp"
#include "overlaps.hpp"
#include "scene/json_text.hpp"
#include "sim/response.hpp"

namespace palpate::app {
namespace {

using Json = nlohmann::ordered_json;

Json tally_json(const Tally& tally) {
  return {{"last", tally.last}, {"largest", tally.largest}, {"total", tally.total}};
}

Json phases_json(const PhaseTimes& times) {
  Json json = Json::object();
  for (std::size_t phase = 0; phase < PhaseTimes::names.size(); ++phase) {
    std::string name(PhaseTimes::names[phase]);
    std::ranges::replace(name, ' ', '_');
    json[name] = {{"mean_ms", 1e3 * times.mean(phase)}, {"median_ms", 1e3 * times.median(phase)}};
  }
  return json;
}

/// Smallest and largest contact stiffness over the pairs of bodies that can touch; null where no pair can.
Json stiffness_json(const RunReport& report) {
  const Bodies& bodies = report.simulation.bodies();
  const ContactResponse response(bodies, report.simulation.contact_materials(), report.obstacles,
                                 report.scene.settings.response, {}, {});
  double low = std::numeric_limits<double>::infinity();
  double high = 0.0;
  for (Index a = 0; a < bodies.body_count(); ++a) {
    for (Index b = 0; b < a; ++b) {
      if (at(report.obstacles, a) != 0 && at(report.obstacles, b) != 0) continue;
      const double stiffness = response.stiffness(a, b);
      low = std::min(low, stiffness);
      high = std::max(high, stiffness);
    }
  }
  return high > 0.0 ? Json{{"min", low}, {"max", high}} : Json();
}

Json wrench_json(const Wrench& wrench) {
  return {
      {"force", to_json(wrench.force)}, {"torque", to_json(wrench.torque)}, {"about", to_json(wrench.about)}};
}

/// Forces on a body in the last step, and the largest in any step.
Json forces_json(const BodyForces& forces, const LargestForce& largest) {
  const auto or_null = [](const std::optional<Wrench>& w) { return w ? wrench_json(*w) : Json(); };
  return {{"contact", wrench_json(forces.contact)},
          {"held", or_null(forces.held)},
          {"tied", or_null(forces.tied)},
          {"grabbed", or_null(forces.grabbed)},
          {"largest_contact", {{"force", largest.force}, {"step", largest.step}}}};
}

Json stress_json(const LargestStress& largest) {
  if (largest.tet < 0) return {};
  return {{"largest_von_mises", largest.von_mises}, {"tet", largest.tet}, {"place", to_json(largest.place)}};
}

/// The largest values of the fields of frames; null without frames.
Json fields_json(const RunReport& report) {
  if (report.maxima.empty()) return {};
  Json json = Json::object();
  for (const FieldMaximum& most : report.maxima) {
    if (most.step < 0) continue;  // no frame had a value of this field
    const FieldInfo* const info = find_field(most.name);
    json[most.name] = {{"largest", most.value},
                       {"unit", unit_name(report.scene.units, info->dimension)},
                       {"step", most.step},
                       {"body", at(report.simulation.bodies().bodies(), most.body).name},
                       {most.of_tets ? "tet" : "point", most.item},
                       {"place", to_json(most.place)}};
  }
  return json;
}

/// The unit of each kind of quantity.
Json units_json(const Units& units) {
  Json json = Json::object();
  for (const auto& [name, kind] :
       {std::pair("length", dimension::length), std::pair("mass", dimension::mass),
        std::pair("time", dimension::time), std::pair("speed", dimension::speed),
        std::pair("force", dimension::force), std::pair("torque", dimension::torque),
        std::pair("stress", dimension::pressure), std::pair("energy", dimension::energy),
        std::pair("stiffness", dimension::stiffness)})
    json[name] = unit_name(units, kind);
  return json;
}

Json bodies_json(const RunReport& report) {
  const Simulation& sim = report.simulation;
  const std::vector<BodyForces> forces = report.probe.forces(sim).bodies;
  const std::vector<LargestStress> stresses = largest_stresses(sim);
  Json list = Json::array();
  for (Index b = 0; b < sim.bodies().body_count(); ++b) {
    const Body& body = at(sim.bodies().bodies(), b);
    const auto& file = report.files[static_cast<std::size_t>(b)];
    Json json{{"name", body.name},
              {"obstacle", at(report.obstacles, b) != 0},
              {"mass", at(sim.masses(), b)},
              {"contact_force", to_json(at(sim.contact_forces(), b))},
              {"forces", forces_json(at(forces, b), at(report.outcome.largest_forces, b))},
              {"stress", stress_json(at(stresses, b))},
              {"displacement", displacement_json(displacement_of(sim, b))},
              {"inverted_tets", inverted_tets(sim, b)}};
    json.update(statistics_json(mesh_statistics(sim.bodies(), sim.bodies().points_rest(), b)));
    json.update(notes_json(file ? &*file : nullptr, at(sim.bodies().notes(), b)));
    list.push_back(std::move(json));
  }
  return list;
}

Json results_json(const RunReport& report) {
  Json views = Json::array();
  for (std::size_t i = 1; i < report.pictures.size(); ++i)
    views.push_back(report.pictures[i].filename().string());
  return {{"folder", utf8_text(report.folder.string())},
          {"series", "frames.pvd"},
          {"frames", report.frames},
          {"metrics", "metrics.csv"},
          {"forces", "forces.csv"},
          {"outcomes",
           report.scene.outcomes.empty() && report.scene.stages.empty() ? Json() : Json("outcomes.json")},
          {"report", report.page ? Json("report.html") : Json()},
          {"picture", report.pictures.empty() ? Json() : Json(report.pictures.front().filename().string())},
          {"views", views}};
}

Json cuckoo_json(const CuckooRun& run) {
  return {{"cells", run.last.cells},
          {"slots", run.last.slots},
          {"buckets", run.last.buckets},
          {"occupancy", run.last.occupancy()},
          {"lowest_occupancy", run.lowest_occupancy},
          {"highest_occupancy", run.highest_occupancy},
          {"bucket_retries", tally_json(run.bucket_retries)},
          {"redistributions", tally_json(run.redistributions)},
          {"growths", tally_json(run.growths)}};
}

void add_build_and_machine(Json& json, const RunReport& report) {
  const io::Machine machine = io::describe_machine();
  json["version"] = PALPATE_VERSION;
  json["commit"] = machine.commit;
  json["compiler"] = machine.compiler;
  json["build_type"] = machine.build_type;
  json["machine"] = {{"cpu", machine.cpu}, {"cores", machine.cores}};
  json["threads"] = report.threads;
}

/// The work that the budget left undone; null without a budget.
Json budget_json(const RunReport& report) {
  if (!report.simulation.settings().detection.budget) return {};
  return {{"late_steps", report.outcome.late_steps},
          {"least_completeness", report.outcome.least_completeness},
          {"steps_without_foresight", report.outcome.steps_without_prediction},
          {"late_bodies", late_body_names(report.simulation.bodies(), report.simulation.detector())}};
}

Json relaxed_json(const std::optional<RelaxReport>& report) {
  if (!report) return {};
  return {{"done", report->relaxed},
          {"steps", report->steps},
          {"contacts_before", report->contacts_before},
          {"contacts_after", report->contacts_after},
          {"deepest_before", report->deepest_before},
          {"deepest_after", report->deepest_after},
          {"allowed_depth", report->allowed_depth},
          {"largest_move", report->largest_move}};
}

void add_outcome(Json& json, const RunReport& report) {
  const RunOutcome& outcome = report.outcome;
  const StepMetrics& metrics = report.simulation.metrics();
  json["relaxed"] = relaxed_json(report.relaxed);
  json["steps"] = outcome.steps;
  json["most_steps"] = report.most_steps;
  json["simulated_time"] = metrics.time;
  json["at_rest"] = outcome.at_rest;
  json["interrupted"] = outcome.interrupted;
  json["resumed_from"] = report.resumed_from ? Json(*report.resumed_from) : Json();
  json["from_stage"] = report.from_stage ? Json(*report.from_stage) : Json();
  json["stages"] = stages_json(report);
  json["error"] = outcome.failure.empty() ? Json() : Json(utf8_text(outcome.failure));
  json["state_hash"] = report.simulation.state_hash();
  json["wall_seconds"] = report.wall_seconds;
  json["phases"] = phases_json(outcome.times);
  json["contacts"] = tally_json(outcome.contacts);
  json["border_edges"] = tally_json(outcome.border_edges);
  json["crossings"] = tally_json(outcome.crossings);
  json["edge_contacts"] = tally_json(outcome.edge_contacts);
  json["candidates"] = tally_json(outcome.candidates);
  json["movers"] = tally_json(outcome.movers);
  json["depth_fallbacks"] = tally_json(outcome.depth_fallbacks);
  json["cuckoo"] = report.simulation.settings().detection.structure != Structure::cuckoo
                       ? Json()
                       : Json{{"points", cuckoo_json(outcome.cuckoo_points)},
                              {"edges", cuckoo_json(outcome.cuckoo_edges)}};
  json["budget"] = budget_json(report);
  json["raised_depths"] = tally_json(outcome.raised_depths);
  json["cancelled_directions"] = tally_json(outcome.cancelled_directions);
  json["regions_without_border"] = tally_json(outcome.regions_without_border);
  json["border_edges_without_crossing"] = tally_json(outcome.border_edges_without_crossing);
  json["folded_pairs"] = tally_json(outcome.folded_pairs);
  json["inverted_tets"] = tally_json(outcome.inverted_tets);
  json["solver"] = {{"iterations", outcome.solver_iterations},
                    {"steps_not_converged", outcome.steps_not_converged},
                    {"steps_divided", outcome.steps_divided}};
  json["steps_too_far"] = outcome.steps_too_far;
  json["thinnest"] = outcome.thinnest > 0.0 ? Json(outcome.thinnest) : Json();
  json["kinetic_energy"] = metrics.kinetic_energy;
  json["elastic_energy"] = metrics.elastic_energy;
  json["largest_speed"] = metrics.largest_speed;
  json["fastest_body"] = metrics.fastest_body;
  json["deepest"] = metrics.deepest;
}

/// The reason for the cell size: the rule and, for "auto", the work with each size that was tried.
Json cell_size_json(const CellSizeChoice& choice) {
  Json json;
  const bool given = std::holds_alternative<double>(choice.wanted);
  json["rule"] =
      given ? std::string("number")
            : std::string(
                  cell_size_rule_names[static_cast<std::size_t>(std::get<CellSizeRule>(choice.wanted))]);
  json["trials"] = Json::array();
  for (const CellSizeTrial& t : choice.trials) {
    json["trials"].push_back(
        {{"cell_size", t.cell_size}, {"lookups", t.lookups}, {"visits", t.visits}, {"work", t.work}});
  }
  return json;
}

}  // namespace

std::vector<LargestStress> largest_stresses(const Simulation& simulation) {
  const Bodies& bodies = simulation.bodies();
  const TissueState tissue = simulation.tissue();
  std::vector<LargestStress> largest(bodies.bodies().size());
  for (std::size_t t = 0; t < tissue.size(); ++t) {
    const Tet& corners = bodies.tets()[t];
    const Index body = bodies.body_of(corners);
    LargestStress& most = at(largest, body);
    if (!(tissue.von_mises[t] > most.von_mises)) continue;
    most.von_mises = tissue.von_mises[t];
    most.tet = static_cast<Index>(t) - at(bodies.bodies(), body).tets.begin;
    most.place = {};
    for (const Index p : corners) most.place += 0.25 * at(simulation.positions(), p);
  }
  return largest;
}

std::vector<std::string> late_body_names(const Bodies& bodies, const Detector& detector) {
  std::vector<std::string> names;
  const auto late = detector.late_bodies();
  for (std::size_t b = 0; b < late.size(); ++b) {
    if (late[b] != 0) names.push_back(bodies.bodies()[b].name);
  }
  return names;
}

std::string late_bodies_text(const Bodies& bodies, const Detector& detector) {
  std::vector<std::string> names = late_body_names(bodies, detector);
  std::ranges::transform(names, names.begin(), shown_name);
  return fmt::format("{}", fmt::join(names, ", "));
}

nlohmann::ordered_json report_json(const RunReport& report) {
  Json json;
  add_build_and_machine(json, report);
  json["scene_file"] = utf8_text(report.scene_file.string());
  add_outcome(json, report);
  json["units"] = units_json(report.scene.units);
  json["resolved"] = {{"cell_size", report.simulation.metrics().detection.cell_size},
                      {"cell_size_choice", cell_size_json(report.simulation.detector().cell_size_choice())},
                      {"cell_doublings", report.simulation.metrics().detection.cell_doublings},
                      {"structure_bytes", report.simulation.detector().structure_bytes()},
                      {"stiffness", stiffness_json(report)}};
  json["results"] = results_json(report);
  json["touching"] = overlaps_json(report.simulation.bodies(),
                                   overlaps(report.simulation.bodies(), report.simulation.detector()));
  json["bodies"] = bodies_json(report);
  json["fields"] = fields_json(report);
  json["scene"] = Json::parse(write_scene(report.scene));
  return json;
}

}  // namespace palpate::app

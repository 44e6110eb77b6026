#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "arrays.hpp"
#include "bind.hpp"
#include "docs.hpp"
#include "fields.hpp"
#include "simulation.hpp"

namespace palpate::python {
namespace {

void bind_metrics(nb::module_& m) {
  nb::class_<StepMetrics> metrics(m, "StepMetrics", doc::StepMetrics);
  Fields<StepMetrics>(metrics)
      .add("step", &StepMetrics::step, doc::StepMetrics_step)
      .add("time", &StepMetrics::time, doc::StepMetrics_time)
      .add("detection", &StepMetrics::detection, doc::StepMetrics_detection)
      .add("solves", &StepMetrics::solves, doc::StepMetrics_solves)
      .add("detections", &StepMetrics::detections, doc::StepMetrics_detections)
      .add("speculative_contacts", &StepMetrics::speculative_contacts, doc::StepMetrics_speculative_contacts)
      .add("stopped_passes", &StepMetrics::stopped_passes, doc::StepMetrics_stopped_passes)
      .add("passes", &StepMetrics::passes, doc::StepMetrics_passes)
      .add("pairs_that_could_pass", &StepMetrics::pairs_that_could_pass,
           doc::StepMetrics_pairs_that_could_pass)
      .add("thinnest", &StepMetrics::thinnest, doc::StepMetrics_thinnest)
      .add("looks_ahead", &StepMetrics::looks_ahead, doc::StepMetrics_looks_ahead)
      .add("solver_iterations", &StepMetrics::solver_iterations, doc::StepMetrics_solver_iterations)
      .add("solver_converged", &StepMetrics::solver_converged, doc::StepMetrics_solver_converged)
      .add("substeps", &StepMetrics::substeps, doc::StepMetrics_substeps)
      .add("order", &StepMetrics::order, doc::StepMetrics_order)
      .add("kinetic_energy", &StepMetrics::kinetic_energy, doc::StepMetrics_kinetic_energy)
      .add("elastic_energy", &StepMetrics::elastic_energy, doc::StepMetrics_elastic_energy)
      .add("largest_speed", &StepMetrics::largest_speed, doc::StepMetrics_largest_speed)
      .add("fastest_body", &StepMetrics::fastest_body, doc::StepMetrics_fastest_body)
      .add("deepest", &StepMetrics::deepest, doc::StepMetrics_deepest)
      .add("inverted_tets", &StepMetrics::inverted_tets, doc::StepMetrics_inverted_tets)
      .add("detection_seconds", &StepMetrics::detection_seconds, doc::StepMetrics_detection_seconds)
      .add("forces_seconds", &StepMetrics::forces_seconds, doc::StepMetrics_forces_seconds)
      .add("solver_seconds", &StepMetrics::solver_seconds, doc::StepMetrics_solver_seconds);
  nb::class_<RelaxReport> report(m, "RelaxReport", doc::RelaxReport);
  Fields<RelaxReport>(report)
      .add("steps", &RelaxReport::steps, doc::RelaxReport_steps)
      .add("relaxed", &RelaxReport::relaxed, doc::RelaxReport_relaxed)
      .add("contacts_before", &RelaxReport::contacts_before, doc::RelaxReport_contacts_before)
      .add("contacts_after", &RelaxReport::contacts_after, doc::RelaxReport_contacts_after)
      .add("deepest_before", &RelaxReport::deepest_before, doc::RelaxReport_deepest_before)
      .add("deepest_after", &RelaxReport::deepest_after, doc::RelaxReport_deepest_after)
      .add("allowed_depth", &RelaxReport::allowed_depth, doc::RelaxReport_allowed_depth)
      .add("largest_move", &RelaxReport::largest_move, doc::RelaxReport_largest_move);
}

/// States as bytes.
void bind_checkpoint(nb::class_<Simulation>& simulation) {
  simulation
      .def(
          "save",
          [](Simulation& s) {
            const std::vector<std::byte> saved = s.save();
            return nb::bytes(saved.data(), saved.size());
          },
          doc::Simulation_save)
      .def(
          "restore",
          [](Simulation& s, const nb::bytes& saved) {
            s.restore({static_cast<const std::byte*>(saved.data()), saved.size()});
          },
          nb::arg("saved"), doc::Simulation_restore);
}

/// Name, kind, value, unit and vector of each outcome.
nb::list outcome_rows(const Simulation& simulation, const std::vector<OutcomeValue>& values) {
  const OutcomeProbe& probe = simulation.outcomes();
  nb::list list;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto& vector = values[i].vector;
    list.append(nb::make_tuple(
        probe.infos()[i].name, probe.infos()[i].kind, values[i].value, probe.unit(i),
        vector ? nb::cast(std::array<double, 3>{vector->x, vector->y, vector->z}) : nb::none()));
  }
  return list;
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_metrics(m);
  nb::class_<Simulation> simulation(m, "Simulation", doc::Simulation);
  bind_checkpoint(simulation);
  refuse_pickling(simulation, "send what save() returns, and restore() it in another of the same scene");
  bind_drive(simulation);
  simulation
      .def(
          "__init__",
          [](Simulation* self, const Model& model, const Scene& scene, int threads) {
            new (self) Simulation(model, scene, threads);
          },
          nb::arg("model"), nb::arg("scene"), nb::arg("threads"))
      .def("step", &Simulation::step, doc::Simulation_step)
      .def_prop_ro(
          "_bodies", [](Simulation& s) -> const Bodies& { return s.idle().bodies(); },
          nb::rv_policy::reference_internal, doc::Simulation_bodies)
      .def_prop_ro(
          "positions", [](Simulation& s) { return copied<double>(s.idle().positions()); },
          nb::rv_policy::reference, doc::Simulation_positions,
          nb::sig("def positions(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "velocities", [](Simulation& s) { return copied<double>(s.idle().velocities()); },
          nb::rv_policy::reference, doc::Simulation_velocities,
          nb::sig("def velocities(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "contact_forces", [](Simulation& s) { return copied<double>(s.idle().contact_forces()); },
          nb::rv_policy::reference, doc::Simulation_contact_forces,
          nb::sig("def contact_forces(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "masses", [](Simulation& s) { return copied<double>(s.idle().masses()); }, nb::rv_policy::reference,
          doc::Simulation_masses, nb::sig("def masses(self) -> numpy.typing.NDArray[numpy.float64]"))
      .def_prop_ro(
          "contacts", [](Simulation& s) { return std::const_pointer_cast<Contacts>(s.contacts()); },
          doc::Simulation_contacts)
      .def_prop_ro(
          "crossings", [](Simulation& s) { return std::const_pointer_cast<Crossings>(s.crossings()); },
          doc::Simulation_crossings)
      .def_prop_ro(
          "edge_contacts", [](Simulation& s) { return s.edge_contacts(); }, doc::Simulation_edge_contacts)
      .def_prop_ro(
          "metrics", [](Simulation& s) { return s.idle().metrics(); }, doc::Simulation_metrics)
      .def_prop_ro(
          "at_rest", [](Simulation& s) { return s.idle().at_rest(); }, doc::Simulation_at_rest)
      .def_prop_ro(
          "state_hash", [](Simulation& s) { return s.idle().state_hash(); }, doc::Simulation_state_hash)
      .def_prop_ro(
          "time_step", [](Simulation& s) { return s.idle().settings().time_step; },
          doc::SimulationSettings_time_step)
      .def_prop_ro(
          "stage",
          [](Simulation& s) -> std::optional<std::string> {
            if (!s.stages().any()) return std::nullopt;
            return s.stages().stage().name;
          },
          "Name of the stage of the scene that is running, or begins with the next step(); after the last "
          "that of it. "
          "None without stages.")
      .def_prop_ro(
          "stages_done", [](Simulation& s) { return s.stages().done(); },
          "Whether all stages of the scene are over; true without stages.")
      .def_prop_ro(
          "stage_endings",
          [](Simulation& s) {
            nb::list list;
            for (const StageEnding& e : s.stages().progress().endings)
              list.append(nb::make_tuple(e.step, e.reached));
            return list;
          },
          nb::sig("def stage_endings(self) -> list[tuple[int, bool]]"),
          "Of each stage that is over its last step, and whether its condition was met.")
      .def_prop_ro(
          "stage_warnings", [](Simulation& s) { return s.stages().warnings(); },
          "Warnings of the stages that have ended, a line each: a condition that was not met, and a body "
          "that was put into a rigid one, as a plate into bone.")
      .def("_cures_of_passes",
           [](Simulation& s) {
             const DetectionSettings& detection = s.idle().settings().detection;
             std::string text = "a smaller time_step";
             if (!detection.edge_contacts) text += R"(, or contact={"edge_contacts": True})";
             if (detection.continuous != ContinuousDetection::full)
               text += R"(, or contact={"continuous": "full"})";
             return text;
           })
      .def(
          "_outcomes", [](Simulation& s) { return outcome_rows(s, s.outcomes().values(s.idle())); },
          nb::sig(
              "def _outcomes(self) -> list[tuple[str, str, float, str, tuple[float, float, float] | None]]"))
      .def(
          "_stage_outcomes",
          [](Simulation& s) {
            nb::list stages;
            for (const auto& values : s.stage_outcomes()) stages.append(outcome_rows(s, values));
            return stages;
          },
          nb::sig("def _stage_outcomes(self) -> list[list[tuple[str, str, float, str, tuple[float, float, "
                  "float] | None]]]"))
      .def_prop_ro("relaxed", &Simulation::relaxed, doc::Simulation_relaxed)
      .def_prop_ro("steps_not_converged", &Simulation::steps_not_converged,
                   "Steps so far of this object in which a solve ended above the tolerance: do not trust "
                   "positions where it is not 0.")
      .def_prop_ro("steps_too_far", &Simulation::steps_too_far,
                   "Steps so far of this object in which something may have gone through a body: "
                   "metrics.passes, or, where not all contacts are sought, metrics.pairs_that_could_pass.")
      .def_prop_ro("most_inverted_tets", &Simulation::most_inverted_tets,
                   "Largest metrics.inverted_tets after a step of this object.");
}

}  // namespace palpate::python

// Whole steps of two scenes with known times of SOFA: with 25 fixed iterations in one solve, like SOFA, and
// converged. One thread. The stack is first brought to rest; the jaw of the head makes its motion of 2 mm
// meanwhile.
#include <filesystem>
#include <string>
#include <utility>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/simulation.hpp>

#include "head_scene.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr int usual_frames = 61;

struct StepCase {
  std::string name;
  Model model;
  SimulationSettings settings;
  int steps_before = 0;     ///< at most
  bool until_rest = false;  ///< and no more than it takes to come to rest
  double sofa_ms = 0.0;     ///< unconverged, of a machine with known references
};

/// Medians over the next frames with these settings, from the same state.
Json measure(Simulation& simulation, const SolverSettings& solver, const std::vector<std::byte>& state,
             int frames) {
  SimulationSettings settings = simulation.settings();
  settings.solver = solver;
  simulation.restore(state);
  simulation.change(settings);
  simulation.step();
  std::vector<double> times;
  std::vector<double> iterations;
  std::vector<double> solves;
  int unconverged = 0;
  for (int i = 0; i < frames; ++i) {
    times.push_back(milliseconds([&] { simulation.step(); }));
    const StepMetrics& metrics = simulation.metrics();
    iterations.push_back(metrics.solver_iterations);
    solves.push_back(metrics.solves);
    if (!metrics.solver_converged) ++unconverged;
  }
  return {{"ms", median(times)},
          {"largest_ms", *std::max_element(times.begin(), times.end())},
          {"iterations", median(iterations)},
          {"solves", median(solves)},
          {"unconverged_steps", unconverged},
          {"contacts", simulation.detector().contacts().size()}};
}

Json measure_course(StepCase c, int frames) {
  Simulation simulation(std::move(c.model), c.settings, 1);
  int steps = 0;
  while (steps < c.steps_before && !(c.until_rest && simulation.at_rest())) {
    simulation.step();
    ++steps;
  }
  const std::vector<std::byte> state = simulation.save();
  SolverSettings fixed = c.settings.solver;
  fixed.fixed_iterations = 25;
  fixed.max_solves = 1;
  fixed.preconditioner = Preconditioner::jacobi;
  SolverSettings converged = c.settings.solver;
  converged.tolerance = 1e-3;
  Json json{{"name", c.name},
            {"points", simulation.bodies().points_rest().size()},
            {"tets", simulation.bodies().tets().size()},
            {"time_step", c.settings.time_step},
            {"steps_before", steps},
            {"at_rest", simulation.at_rest()},
            {"frames", frames},
            {"sofa_ms", c.sofa_ms},
            {"sofa_scaled_ms", c.sofa_ms * machine_scale(machine_references())}};
  json["fixed"] = measure(simulation, fixed, state, frames);
  for (std::size_t k = 0; k < preconditioner_names.size(); ++k) {
    converged.preconditioner = static_cast<Preconditioner>(k);
    json["converged"][std::string(preconditioner_names[k])] = measure(simulation, converged, state, frames);
  }
  return json;
}

StepCase stacking(const std::filesystem::path& file) {
  const Scene scene = read_scene(file);
  StepCase c{
      .name = "stacking at rest",
      .model = load_model(scene, [](const std::filesystem::path& path) { return io::read_mesh(path).mesh; }),
      .settings = scene.settings,
      .steps_before = 2000,
      .until_rest = true,
      .sofa_ms = 22.4};
  return c;
}

StepCase head(const std::filesystem::path& folder) {
  HeadScene scene = head_scene(folder);
  return {.name = "head",
          .model = std::move(scene.model),
          .settings = scene.settings,
          .steps_before = 20,
          .sofa_ms = 17.2};
}

}  // namespace

Part step_part(const SpeedEffort& effort) {
  const int frames = effort.frames_or(usual_frames);
  Part part{
      "step",
      {{"stacking at rest", 1e4,
        [=, file = effort.scenes / "stacking.json"] { return measure_course(stacking(file), frames); }}},
      step_rows};
  if (!effort.skull.empty())
    part.cases.push_back(
        {"head", 23313, [=, folder = effort.skull] { return measure_course(head(folder), frames); }});
  return part;
}

}  // namespace palpate::bench

// Whole steps of two scenes of which DESIGN.md has what SOFA takes: with 25 fixed iterations in one solve, as
// SOFA makes them, and converged. One thread.
//
//   palpate_bench_step JSON STACKING_SCENE [SKULL_FOLDER]
//
// The stack is first brought to rest; the jaw of the head goes its 2 mm meanwhile.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include <palpate/error.hpp>
#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "io/mesh_reader.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr int frames = 61;

struct Case {
  std::string name;
  Model model;
  SimulationSettings settings;
  int steps_before = 0;     ///< at most
  bool until_rest = false;  ///< and no more than it takes to come to rest
  double sofa_ms = 0.0;     ///< unconverged, DESIGN.md
};

/// Medians over the next frames with these settings, from the same state.
nlohmann::json measure(Simulation& simulation, const SolverSettings& solver,
                       const std::vector<std::byte>& state) {
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

nlohmann::json run_case(Case& c) {
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
  nlohmann::json json{{"name", c.name},
                      {"points", simulation.bodies().points_rest().size()},
                      {"tets", simulation.bodies().tets().size()},
                      {"time_step", c.settings.time_step},
                      {"steps_before", steps},
                      {"at_rest", simulation.at_rest()},
                      {"frames", frames},
                      {"sofa_ms", c.sofa_ms}};
  json["fixed"] = measure(simulation, fixed, state);
  for (std::size_t k = 0; k < preconditioner_names.size(); ++k) {
    converged.preconditioner = static_cast<Preconditioner>(k);
    json["converged"][std::string(preconditioner_names[k])] = measure(simulation, converged, state);
  }
  return json;
}

Case stacking(const std::filesystem::path& file) {
  const Scene scene = read_scene(file);
  Case c{
      .name = "stacking at rest",
      .model = load_model(scene, [](const std::filesystem::path& path) { return io::read_mesh(path).mesh; }),
      .settings = scene.settings,
      .steps_before = 2000,
      .until_rest = true,
      .sofa_ms = 22.4};
  return c;
}

/// Soft tissue on bones, of which the lower jaw goes 2 mm along -y.
Case head(const std::filesystem::path& folder) {
  Case c{.name = "head", .model = {}, .settings = {}, .steps_before = 20, .sofa_ms = 17.2};
  for (const char* part : {"skull", "lower", "upper", "soft"}) {
    TetMesh mesh = io::read_mesh(folder / ("hq_" + std::string(part) + ".mesh")).mesh;
    for (Vec3& p : mesh.points) p = 1e-3 * p;  // the files are in mm
    c.model.bodies.add(part, mesh);
  }
  c.settings.gravity = {};
  c.model.materials.assign(4, {1e4, 0.4, 1000.0, 0.0, 0.002});
  c.model.obstacles = {1, 1, 1, 0};
  relax(c.model, c.settings, {}, 1);
  Motion motion;
  motion.keyframes = {{.time = 0.0}, {.time = 0.8, .translate = {0.0, -0.002, 0.0}}};
  c.model.motions = {motion};
  c.model.motion_of_point.assign(c.model.bodies.points_rest().size(), -1);
  const Range jaw = c.model.bodies.bodies()[1].points;
  for (Index p = jaw.begin; p < jaw.end; ++p) c.model.motion_of_point[static_cast<std::size_t>(p)] = 0;
  return c;
}

int run(int argc, char** argv) {
  nlohmann::json json{{"context", machine_context()}, {"references", machine_references()}};
  std::vector<Case> cases;
  cases.push_back(stacking(argv[2]));
  if (argc > 3) cases.push_back(head(argv[3]));
  for (Case& c : cases) {
    json["cases"].push_back(run_case(c));
    std::fprintf(stderr, "%s: done\n", c.name.c_str());
    std::ofstream(argv[1]) << json.dump(1) << '\n';
  }
  return 0;
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) {
    std::fprintf(stderr, "usage: palpate_bench_step JSON STACKING_SCENE [SKULL_FOLDER]\n");
    return 2;
  }
  try {
    return palpate::bench::run(argc, argv);
  } catch (const palpate::Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

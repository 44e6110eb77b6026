#include <fmt/format.h>

#include <palpate/simulation.hpp>

#include "measure/query_scenes.hpp"
#include "measure/replay.hpp"
#include "measure/scaling.hpp"
#include "stopwatch.hpp"

namespace palpate::measure {

Section step_growth(const ScalingEffort& effort, double most_tets) {
  constexpr int iterations = 25;
  constexpr int warm_up = 2;
  constexpr int measured = 6;  // steps per size: contacts differ from step to step
  Section section{.id = "step-growth",
                  .title = "A whole step against size",
                  .ours = fmt::format("The stack falls; its membranes touch at the start. One thread; {} "
                                      "iterations of the solver in each "
                                      "solve, so that sizes can be compared (a converged solution may need "
                                      "another number). A step has as "
                                      "many solves as its contacts need. So the table has the time of a "
                                      "detection, and the rest of a step "
                                      "divided by its solves. Medians over steps {} to {}, for each size.",
                                      iterations, warm_up + 1, warm_up + measured),
                  .table = {{"tets", "points", "steps", "solves a step", "detection, ms",
                             "contact forces, ms", "dynamics, ms", "whole, ms", "ns a tet"},
                            {}}};
  std::vector<PhaseGrowth> grown{
      {.name = "detection"}, {.name = "contact forces"}, {.name = "dynamics"}, {.name = "whole"}};
  for (const double wanted : effort.step_tets) {
    if (wanted > most_tets) continue;
    const Model model = stacking_model(stacking_cells(wanted));
    const auto tets = static_cast<double>(model.bodies.tets().size());
    SimulationSettings settings;
    settings.solver.fixed_iterations = iterations;
    Simulation simulation(model, settings, 1);
    std::vector<std::vector<double>> times(grown.size());
    int solves = 0;
    for (int step = 0; step < warm_up + measured; ++step) {
      const Stopwatch watch;
      const StepMetrics& metrics = simulation.step();
      const double whole = watch.seconds();
      if (step < warm_up) continue;
      solves += metrics.solves;
      const double milliseconds = 1e3 / metrics.solves;
      times[0].push_back(1e3 * total(metrics.detection_seconds) / metrics.detections);
      times[1].push_back(milliseconds * metrics.forces_seconds);
      times[2].push_back(milliseconds * metrics.solver_seconds);
      times[3].push_back(milliseconds * whole);
    }
    std::vector<nlohmann::ordered_json> row{
        model.bodies.tets().size(), model.bodies.points_rest().size(), times[3].size(),
        static_cast<double>(solves) / static_cast<double>(times[3].size())};
    for (std::size_t p = 0; p < grown.size(); ++p) {
      const Measure measure =
          measure_of(fmt::format("{:.0f} tets, {}, a solve", tets, grown[p].name), std::move(times[p]));
      grown[p].add(tets, measure);
      row.emplace_back(measure.median);
      section.measures.push_back(measure);
    }
    row.emplace_back(1e6 * grown.back().milliseconds.back() / tets);
    section.table.rows.push_back(std::move(row));
    if (!section.result_hash.empty()) section.result_hash += ' ';
    section.result_hash += simulation.state_hash();
  }
  describe_growth(section, "A solve of a step", grown);
  return section;
}

}  // namespace palpate::measure

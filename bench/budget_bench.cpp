// What a budget in milliseconds keeps, and what it costs (docs/budget.md):
//
//   palpate_bench_budget RESULT.json SCENE STEPS MILLISECONDS...
//
// Runs the scene for so many steps without a budget, and with each; one thread. For each step: time of all
// its detections, share of the clusters asked, and whether the system put the thread aside meanwhile. At the
// end: how far points are from where they are without a budget (the paper's Table 2).
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"
#include "io/machine.hpp"
#include "scene_steps.hpp"

namespace {

using namespace palpate;
using Json = nlohmann::ordered_json;

struct Run {
  std::vector<double> milliseconds;
  std::vector<double> completeness;
  std::vector<std::int64_t> preempted;
  std::vector<int> detections;
  std::vector<std::size_t> contacts;
  std::int64_t without_foresight = 0;
  std::vector<Vec3> positions;
};

double total(const DetectionTimes& t) {
  return 1e3 * (t.grid + t.contacts + t.border_edges + t.crossings + t.depth);
}

Run run(const std::string& scene, int steps, const std::optional<Budget>& budget) {
  Simulation simulation = bench::simulation_of(scene, budget, 1);
  Run result;
  for (int i = 0; i < steps; ++i) {
    const std::int64_t before = bench::preemptions();
    const StepMetrics& m = simulation.step();
    result.milliseconds.push_back(total(m.detection_seconds));
    result.preempted.push_back(bench::preemptions() - before);
    result.completeness.push_back(m.detection.completeness);
    result.detections.push_back(m.detections);
    result.contacts.push_back(m.detection.contacts);
    result.without_foresight += m.looks_ahead ? 0 : 1;
  }
  const auto positions = simulation.positions();
  result.positions.assign(positions.begin(), positions.end());
  return result;
}

double quantile(std::vector<double> values, double share) {
  std::ranges::sort(values);
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::ceil(share * last))];
}

Json spread(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return {{"mean", sum / static_cast<double>(values.size())},
          {"median", quantile(values, 0.5)},
          {"p99", quantile(values, 0.99)},
          {"p999", quantile(values, 0.999)},
          {"max", quantile(values, 1.0)}};
}

/// Distances of all points that moved in either run.
Json deviation(const Run& run, const Run& exact) {
  std::vector<double> distances;
  for (std::size_t p = 0; p < run.positions.size(); ++p)
    distances.push_back(length(run.positions[p] - exact.positions[p]));
  double sum = 0.0;
  for (const double d : distances) sum += d;
  const double mean = sum / static_cast<double>(distances.size());
  double squares = 0.0;
  for (const double d : distances) squares += (d - mean) * (d - mean);
  return {{"max", *std::ranges::max_element(distances)},
          {"mean", mean},
          {"standard_deviation", std::sqrt(squares / static_cast<double>(distances.size()))}};
}

Json report(const Run& run, const Run& exact, double budget) {
  std::vector<double> undisturbed;
  std::int64_t within = 0;
  std::int64_t within_undisturbed = 0;
  for (std::size_t i = 0; i < run.milliseconds.size(); ++i) {
    const bool in_time = run.milliseconds[i] <= 1.1 * budget;
    within += in_time ? 1 : 0;
    if (run.preempted[i] != 0) continue;
    undisturbed.push_back(run.milliseconds[i]);
    within_undisturbed += in_time ? 1 : 0;
  }
  const auto steps = static_cast<double>(run.milliseconds.size());
  std::vector<double> contacts(run.contacts.begin(), run.contacts.end());
  return {{"milliseconds", budget},
          {"all_steps", spread(run.milliseconds)},
          {"undisturbed", undisturbed.empty() ? Json() : spread(undisturbed)},
          {"steps_put_aside", run.milliseconds.size() - undisturbed.size()},
          {"share_within", static_cast<double>(within) / steps},
          {"share_within_undisturbed", undisturbed.empty() ? Json()
                                                           : Json(static_cast<double>(within_undisturbed) /
                                                                  static_cast<double>(undisturbed.size()))},
          {"completeness", spread(run.completeness)},
          {"least_completeness", *std::ranges::min_element(run.completeness)},
          {"steps_without_foresight", run.without_foresight},
          {"contacts", spread(contacts)},
          {"deviation", deviation(run, exact)},
          {"steps", run.milliseconds},
          {"put_aside", run.preempted}};
}

double number(const char* text) {
  double value = 0.0;
  std::from_chars(text, text + std::string(text).size(), value);
  return value;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 5) {
    std::fprintf(stderr, "usage: palpate_bench_budget RESULT.json SCENE STEPS MILLISECONDS...\n");
    return 2;
  }
  const std::string scene = argv[2];
  const int steps = static_cast<int>(number(argv[3]));
  const Run exact = run(scene, steps, std::nullopt);
  const io::Machine machine = io::describe_machine();
  Json json{{"scene", scene}, {"steps", steps}, {"cpu", machine.cpu}, {"commit", machine.commit}};
  json["exact"] = {{"all_steps", spread(exact.milliseconds)}, {"steps", exact.milliseconds}};
  json["budgets"] = Json::array();
  for (int i = 4; i < argc; ++i) {
    const double budget = number(argv[i]);
    json["budgets"].push_back(report(run(scene, steps, Budget{.milliseconds = budget}), exact, budget));
    std::fprintf(stderr, "budget of %s ms done\n", argv[i]);
  }
  io::write_atomically(argv[1], json.dump() + "\n");
  return 0;
}

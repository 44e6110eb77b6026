// Measures how well a budget in milliseconds is kept, and its cost (docs/budget.md):
//
// palpate_bench_budget RESULT.json SCENE STEPS MANY_STEPS FRAMES MILLISECONDS...
//
// Runs the scene for so many steps without a budget, and with each; one thread. At the end: how far points
// are from where they are without a budget (the paper's Table 2). Then MANY_STEPS with each budget and with
// disturbances (disturbances.hpp). Then detection alone, FRAMES times: the positions of the run without a
// budget, to and fro, each time with a tremble of its own. For each step or detection: its time, the fraction
// of the clusters queried, and whether the system put the thread aside meanwhile, which no program can
// predict.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "disturbances.hpp"
#include "geometry/vector.hpp"
#include "io/atomic_file.hpp"
#include "io/machine.hpp"
#include "scene_steps.hpp"

namespace {

using namespace palpate;
using Json = nlohmann::ordered_json;

/// Detections, one after the other.
struct Series {
  std::vector<double> milliseconds;
  std::vector<double> completeness;
  std::vector<std::int64_t> put_aside;
  std::vector<double> contacts;
  std::vector<double> rough;  ///< fraction of the contacts whose depth was not computed

  void add(double time, std::int64_t aside, const DetectionCounts& counts) {
    milliseconds.push_back(time);
    put_aside.push_back(aside);
    completeness.push_back(counts.completeness);
    contacts.push_back(static_cast<double>(counts.contacts));
    rough.push_back(static_cast<double>(counts.rough_depths) / std::max(1.0, contacts.back()));
  }
};

struct Run {
  Series steps;  ///< all detections of each
  std::int64_t without_prediction = 0;
  std::vector<Vec3> end;
  std::vector<std::vector<Vec3>> frames;  ///< of each step
};

double total(const DetectionTimes& t) {
  return 1e3 * (t.grid + t.contacts + t.border_edges + t.crossings + t.depth);
}

Run run(const std::string& scene, int steps, const std::optional<Budget>& budget, bool keep_frames,
        bool disturbed = false) {
  Simulation simulation = bench::simulation_of(scene, budget, 1);
  std::optional<bench::Disturbances> disturbances;
  if (disturbed) disturbances.emplace(simulation, bench::motions_of(scene), bench::rigid_bodies_of(scene), 1);
  Run result;
  for (int i = 0; i < steps; ++i) {
    if (disturbances) disturbances->apply(simulation);
    const std::int64_t before = bench::preemptions();
    const StepMetrics& m = simulation.step();
    result.steps.add(total(m.detection_seconds), bench::preemptions() - before, m.detection);
    result.without_prediction += m.looks_ahead ? 0 : 1;
    result.end.assign(simulation.positions().begin(), simulation.positions().end());
    if (keep_frames) result.frames.push_back(result.end);
  }
  return result;
}

/// Detection alone, repeatedly over the frames of a run.
Series detect(const std::string& scene, const std::vector<std::vector<Vec3>>& frames, int count,
              const std::optional<Budget>& budget) {
  const Simulation simulation = bench::simulation_of(scene, std::nullopt, 1);
  DetectionSettings settings = simulation.settings().detection;
  settings.budget = budget;
  Detector detector(simulation.bodies(), settings, bench::rigid_bodies_of(scene), 1);
  const double tremble = 1e-3 * mesh_statistics(simulation.bodies(), frames.front()).edge_length.mean;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> any(-tremble, tremble);
  Series series;
  std::vector<Vec3> positions;
  detector.detect(frames.front());
  const std::size_t period = 2 * frames.size();
  for (int f = 0; f < count; ++f) {
    const std::size_t place = static_cast<std::size_t>(f) % period;
    positions = frames[place < frames.size() ? place : period - 1 - place];
    const Vec3 shift{any(random), any(random), any(random)};
    for (std::size_t p = 0; p < positions.size(); p += 2) positions[p] += shift;
    const std::int64_t before = bench::preemptions();
    detector.detect(positions);
    series.add(total(detector.times()), bench::preemptions() - before, detector.counts());
  }
  return series;
}

double quantile(std::vector<double> values, double fraction) {
  std::ranges::sort(values);
  const auto last = static_cast<double>(values.size() - 1);
  return values[static_cast<std::size_t>(std::ceil(fraction * last))];
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

Json deviation(const Run& run, const Run& exact) {
  std::vector<double> distances;
  for (std::size_t p = 0; p < run.end.size(); ++p) distances.push_back(length(run.end[p] - exact.end[p]));
  double sum = 0.0;
  for (const double d : distances) sum += d;
  const double mean = sum / static_cast<double>(distances.size());
  double squares = 0.0;
  for (const double d : distances) squares += (d - mean) * (d - mean);
  return {{"max", *std::ranges::max_element(distances)},
          {"mean", mean},
          {"standard_deviation", std::sqrt(squares / static_cast<double>(distances.size()))}};
}

/// Fraction of the detections that kept the budget, within 10 %.
Json kept(const Series& series, double budget) {
  std::vector<double> undisturbed;
  std::int64_t within = 0;
  std::int64_t within_undisturbed = 0;
  for (std::size_t i = 0; i < series.milliseconds.size(); ++i) {
    const bool in_time = series.milliseconds[i] <= 1.1 * budget;
    within += in_time ? 1 : 0;
    if (series.put_aside[i] != 0) continue;
    undisturbed.push_back(series.milliseconds[i]);
    within_undisturbed += in_time ? 1 : 0;
  }
  const auto fraction = [](std::int64_t part, std::size_t all) {
    return static_cast<double>(part) / static_cast<double>(std::max<std::size_t>(all, 1));
  };
  return {{"count", series.milliseconds.size()},
          {"time", spread(series.milliseconds)},
          {"put_aside", series.milliseconds.size() - undisturbed.size()},
          {"time_undisturbed", undisturbed.empty() ? Json() : spread(undisturbed)},
          {"share_within", fraction(within, series.milliseconds.size())},
          {"share_within_undisturbed", fraction(within_undisturbed, undisturbed.size())},
          {"completeness", spread(series.completeness)},
          {"least_completeness", *std::ranges::min_element(series.completeness)},
          {"rough_depths", spread(series.rough)},
          {"contacts", spread(series.contacts)}};
}

double number(const char* text) {
  double value = 0.0;
  std::from_chars(text, text + std::string(text).size(), value);
  return value;
}

void measure(int argc, char** argv) {
  const std::string scene = argv[2];
  const int steps = static_cast<int>(number(argv[3]));
  const int many = static_cast<int>(number(argv[4]));
  const int frames = static_cast<int>(number(argv[5]));
  const Run exact = run(scene, steps, std::nullopt, true);
  const Series all = detect(scene, exact.frames, frames, std::nullopt);
  const io::Machine machine = io::describe_machine();
  Json json{{"scene", scene}, {"cpu", machine.cpu}, {"commit", machine.commit}};
  json["exact"] = {{"steps", kept(exact.steps, 1e9)},
                   {"detections", kept(all, 1e9)},
                   {"milliseconds", all.milliseconds},
                   {"step_milliseconds", exact.steps.milliseconds}};
  json["budgets"] = Json::array();
  for (int i = 6; i < argc; ++i) {
    const double budget = number(argv[i]);
    const Run limited = run(scene, steps, Budget{.milliseconds = budget}, false);
    const Run disturbed = run(scene, many, Budget{.milliseconds = budget}, false, true);
    const Series series = detect(scene, exact.frames, frames, Budget{.milliseconds = budget});
    json["budgets"].push_back({{"budget", budget},
                               {"steps", kept(limited.steps, budget)},
                               {"steps_without_foresight", limited.without_prediction},
                               {"deviation", deviation(limited, exact)},
                               {"many_steps", kept(disturbed.steps, budget)},
                               {"many_steps_milliseconds", disturbed.steps.milliseconds},
                               {"detections", kept(series, budget)},
                               {"milliseconds", series.milliseconds},
                               {"put_aside", series.put_aside}});
    std::fprintf(stderr, "budget of %s ms done\n", argv[i]);
    io::write_atomically(argv[1], json.dump() + "\n");
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 7) {
    std::fprintf(stderr,
                 "usage: palpate_bench_budget RESULT.json SCENE STEPS MANY_STEPS FRAMES MILLISECONDS...\n");
    return 2;
  }
  try {
    measure(argc, argv);
  } catch (const std::exception& error) {  // a budget that is too small may end a run
    std::fprintf(stderr, "palpate_bench_budget: %s\n", error.what());
    return 1;
  }
  return 0;
}

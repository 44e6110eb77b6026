#include "measure/scaling.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <malloc.h>
#include <numeric>
#include <utility>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "measure/query_scenes.hpp"
#include "measure/replay.hpp"
#include "measure/report.hpp"
#include "sim/state_hash.hpp"
#include "stopwatch.hpp"

namespace palpate::measure {
namespace {

constexpr std::array<std::pair<const char*, double DetectionTimes::*>, 5> phases{
    {{"points into cells", &DetectionTimes::grid},
     {"points in tets", &DetectionTimes::contacts},
     {"border edges", &DetectionTimes::border_edges},
     {"crossings", &DetectionTimes::crossings},
     {"depth", &DetectionTimes::depth}}};

/// A detector of a scene, and its times for the frames so far.
struct Runner {
  Runner(const QueryScene& scene, int n) : threads(n), detector(scene.bodies, {}, scene.immovable(), n) {}
  int threads;
  Detector detector;
  std::vector<DetectionTimes> frames{};
  std::uint64_t hash = fnv1a({});
};

/// Runs the runners on frame after frame in rotating order: two frames as a warm-up, then at least three and
/// at most 41, as time allows.
void run_frames(const QueryScene& scene, std::vector<Runner>& runners, double seconds) {
  constexpr int warm_up = 2;
  std::vector<Vec3> positions;
  double spent = 0.0;
  for (int frame = 0; frame < warm_up + 3 || (frame < warm_up + 41 && spent < seconds); ++frame) {
    scene.place(static_cast<std::uint32_t>(frame), positions);
    for (std::size_t round = 0; round < runners.size(); ++round) {
      Runner& runner = runners[(round + static_cast<std::size_t>(frame)) % runners.size()];
      runner.detector.detect(positions);
      // The hash uses only frames that every run has: the number of others depends on time.
      if (frame < warm_up + 3) runner.hash = hash_of(runner.detector.contacts(), runner.hash);
      if (frame < warm_up) continue;
      runner.frames.push_back(runner.detector.times());
      spent += total(runner.frames.back());
    }
  }
  for (const Runner& runner : runners) {
    if (runner.hash == runners.front().hash) continue;
    throw Error("benchmark", fmt::format("{}, {} threads", scene.name, runner.threads),
                "contacts that differ", "the contacts found with one thread");
  }
}

std::vector<double> milliseconds_of(const Runner& runner,
                                    const std::function<double(const DetectionTimes&)>& seconds) {
  std::vector<double> values(runner.frames.size());
  std::ranges::transform(runner.frames, values.begin(),
                         [&](const DetectionTimes& times) { return 1e3 * seconds(times); });
  return values;
}
std::vector<double> milliseconds_of(const Runner& runner, double DetectionTimes::*phase) {
  return milliseconds_of(runner, [phase](const DetectionTimes& times) { return times.*phase; });
}
std::vector<double> milliseconds_of(const Runner& runner) {
  return milliseconds_of(runner, [](const DetectionTimes& times) { return total(times); });
}

void add_hash(Section& section, std::uint64_t hash) {
  if (!section.result_hash.empty()) section.result_hash += ' ';
  section.result_hash += hash_text(hash);
}

}  // namespace

ScalingEffort quick_scaling() {
  return {.tets = {1e4, 3.16e4, 1e5, 3.16e5, 1e6},
          .step_tets = {1e4, 3.16e4, 1e5},
          .seconds = 2.0,
          .threads = thread_counts()};
}

ScalingEffort full_scaling() {
  return {.tets = {1e4, 3.16e4, 1e5, 3.16e5, 1e6, 3.16e6, 1e7},
          .step_tets = {1e4, 3.16e4, 1e5, 3.16e5, 1e6},
          .seconds = 10.0,
          .threads = thread_counts()};
}

double growth_exponent(std::span<const double> x, std::span<const double> y) {
  const auto n = static_cast<double>(x.size());
  double sx = 0.0;
  double sy = 0.0;
  double sxx = 0.0;
  double sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double u = std::log(x[i]);
    const double v = std::log(y[i]);
    sx += u;
    sy += v;
    sxx += u * u;
    sxy += u * v;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::size_t allocated_bytes() {
#ifdef __GLIBC__
  const struct mallinfo2 info = ::mallinfo2();
  return info.uordblks + info.hblkhd;
#else
  return 0;
#endif
}

void PhaseGrowth::add(double size, const Measure& measure) {
  tets.push_back(size);
  milliseconds.push_back(measure.median);
  lower.push_back(measure.lower_quartile);
  upper.push_back(measure.upper_quartile);
}

void describe_growth(Section& section, const std::string& what, const std::vector<PhaseGrowth>& list) {
  Chart time{.title = what + " against size", .x_label = "tets", .y_label = "ms", .logarithmic = true};
  Chart each{.title = what + " for each tet", .x_label = "tets", .y_label = "ns a tet", .logarithmic = true};
  std::string text;
  std::string noisy;
  for (const PhaseGrowth& phase : list) {
    time.series.push_back({phase.name, phase.tets, phase.milliseconds});
    Series& line = each.series.emplace_back(phase.name, phase.tets, std::vector<double>{});
    for (std::size_t i = 0; i < phase.tets.size(); ++i)
      line.y.push_back(1e6 * phase.milliseconds[i] / phase.tets[i]);
    bool apart = true;
    for (std::size_t i = 1; i < phase.tets.size(); ++i) apart = apart && phase.upper[i - 1] < phase.lower[i];
    if (phase.tets.size() > 1 && !apart) {
      noisy += (noisy.empty() ? "" : ", ") + phase.name;
    } else if (phase.tets.size() > 1) {
      text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", phase.name,
                          growth_exponent(phase.tets, phase.milliseconds));
    }
  }
  section.charts = {std::move(time), std::move(each)};
  if (!text.empty()) text = "Exponents of the growth of time with the number of tets (1 is linear): " + text;
  if (!noisy.empty()) {
    text += fmt::format("{}no exponent where quartiles of neighbouring sizes overlap: {}",
                        text.empty() ? "" : "; ", noisy);
  }
  section.why = text.empty() ? "one size shows no growth" : text;
}

Section growth(const ScalingEffort& effort, double most_tets) {
  Section section{
      .id = "growth",
      .title = "Detection against size",
      .ours =
          "The stack of membranes with more and more cells, 2 % movers, one thread; medians. The "
          "bytes of the structures count the grids of points and of border edges. The bytes of meshes and "
          "detector count the memory that they have allocated and keep.",
      .table = {{"tets", "points", "contacts", "border edges", "frames"}, {}}};
  for (const auto& [name, phase] : phases) section.table.columns.push_back(fmt::format("{}, ms", name));
  for (const char* name :
       {"whole, ms", "ns a tet", "structures, bytes a point", "meshes, bytes a tet", "detector, bytes a tet"})
    section.table.columns.emplace_back(name);
  std::vector<PhaseGrowth> grown;
  grown.reserve(phases.size() + 1);
  for (const auto& [name, phase] : phases) grown.push_back({.name = name});
  grown.push_back({.name = "whole"});
  for (const double wanted : effort.tets) {
    if (wanted > most_tets) continue;
    const std::size_t before = allocated_bytes();
    const QueryScene scene = stacking_scene(stacking_cells(wanted));
    const std::size_t with_meshes = allocated_bytes();
    std::vector<Runner> runners;
    runners.emplace_back(scene, 1);
    run_frames(scene, runners, effort.seconds);
    const Runner& runner = runners.front();
    const std::size_t with_detector = allocated_bytes();
    const auto tets = static_cast<double>(scene.bodies.tets().size());
    const auto points = static_cast<double>(scene.places.size());
    std::vector<nlohmann::ordered_json> row{scene.bodies.tets().size(), scene.places.size(),
                                            runner.detector.counts().contacts,
                                            runner.detector.counts().border_edges, runner.frames.size()};
    for (std::size_t p = 0; p <= phases.size(); ++p) {
      const bool whole = p == phases.size();
      const Measure measure =
          measure_of(fmt::format("{}, {}", scene.name, grown[p].name),
                     whole ? milliseconds_of(runner) : milliseconds_of(runner, phases[p].second));
      grown[p].add(tets, measure);
      row.emplace_back(measure.median);
      section.measures.push_back(measure);
    }
    row.emplace_back(1e6 * grown.back().milliseconds.back() / tets);
    row.emplace_back(static_cast<double>(runner.detector.structure_bytes()) / points);
    const auto gained = [&](std::size_t from, std::size_t to) {
      return to > from ? nlohmann::ordered_json(static_cast<double>(to - from) / tets) : nullptr;
    };
    row.emplace_back(gained(before, with_meshes));
    row.emplace_back(gained(with_meshes, with_detector));
    section.table.rows.push_back(std::move(row));
    add_hash(section, runner.hash);
  }
  describe_growth(section, "Detection", grown);
  return section;
}

Section thread_scaling(const ScalingEffort& effort, double most_tets) {
  Section section{
      .id = "threads",
      .title = "Detection against threads",
      .ours =
          "The stacks of the section before. The thread counts alternate on the same frames and must find "
          "the "
          "same bits. Medians of wall time.",
      .table = {{"tets", "threads", "whole, ms", "times one thread", "parallel fraction, %"}, {}}};
  Chart chart{.title = "Speed-up by threads", .x_label = "threads", .y_label = "times as fast as one thread"};
  std::string best_text = "this machine has one thread only";
  double best = 0.0;
  for (const double wanted : effort.tets) {
    if (wanted > std::min(most_tets, 4e6)) continue;
    const QueryScene scene = stacking_scene(stacking_cells(wanted));
    std::vector<Runner> runners;
    runners.reserve(effort.threads.size());
    for (const int n : effort.threads) runners.emplace_back(scene, n);
    run_frames(scene, runners, effort.seconds);
    Series line{fmt::format("{} tets", scene.bodies.tets().size()), {}, {}};
    double one = 0.0;
    for (const Runner& runner : runners) {
      const Measure measure =
          measure_of(fmt::format("{}, {} threads", scene.name, runner.threads), milliseconds_of(runner));
      section.measures.push_back(measure);
      if (runner.threads == 1) one = measure.median;
      const double gain = one / measure.median;
      // Amdahl's law as the paper has it; it is not defined for a speed-up below one.
      const bool has_fraction = runner.threads > 1 && gain > 1.0;
      const double fraction = has_fraction ? 100.0 * (1.0 - 1.0 / gain) / (1.0 - 1.0 / runner.threads) : 0.0;
      section.table.rows.push_back({scene.bodies.tets().size(), runner.threads, measure.median, gain,
                                    has_fraction ? nlohmann::ordered_json(fraction) : nullptr});
      line.x.push_back(runner.threads);
      line.y.push_back(gain);
      if (runner.threads > 1 && gain > best) {
        best = gain;
        best_text = fmt::format("{} threads are at best {:.2f} times as fast as one, with {} tets",
                                runner.threads, gain, scene.bodies.tets().size());
      }
    }
    chart.series.push_back(std::move(line));
    add_hash(section, runners.front().hash);
  }
  if (effort.threads.size() > 1) section.charts = {std::move(chart)};
  section.why = best_text;
  return section;
}

}  // namespace palpate::measure

// Whole detections and whole steps with 1, 2, 4, ... threads, up to the cores of the machine: what the counts
// of instructions_part.cpp predict, by the clock. All thread counts take turns, and must have the same result
// to the bit.
#include <algorithm>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/simulation.hpp>

#include "measure/query_scenes.hpp"
#include "measure/replay.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "sim/state_hash.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "stopwatch.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr int usual_frames = 41;
constexpr int usual_steps = 12;
constexpr int warm_up = 4;

/// 1, 2, 4, ...: at least two of them.
std::vector<int> thread_counts() {
  const int cores = static_cast<int>(std::thread::hardware_concurrency());
  std::vector<int> counts{1, 2};
  while (2 * counts.back() <= cores) counts.push_back(2 * counts.back());
  return counts;
}

/// The times of all frames for each of some phases, with one number of threads, ms by the clock.
class FrameTimes {
 public:
  explicit FrameTimes(int threads) : threads_(threads) {}
  void add(const char* phase, double seconds) { of_phase_[phase].push_back(1e3 * seconds); }
  /// Medians of the times, and of their ratios to those of the same frames with one thread.
  [[nodiscard]] Json json(const FrameTimes& one) const {
    Json json{{"threads", threads_}};
    for (const auto& [phase, times] : of_phase_) {
      std::vector<double> faster;
      for (std::size_t frame = 0; frame < times.size(); ++frame)
        faster.push_back(one.of_phase_.at(phase)[frame] / std::max(times[frame], 1e-6));
      json[phase] = {{"ms", median(times)}, {"faster", median(faster)}};
    }
    return json;
  }

 private:
  int threads_;
  std::map<std::string, std::vector<double>> of_phase_;
};

Json result(const std::string& name, std::size_t tets, int frames, const std::deque<FrameTimes>& times) {
  Json json{{"name", name}, {"tets", tets}, {"frames", frames}, {"times", Json::array()}};
  for (const FrameTimes& of_count : times) json["times"].push_back(of_count.json(times.front()));
  return json;
}

void add_phases(FrameTimes& times, const DetectionTimes& seconds) {
  times.add("grid", seconds.grid);
  times.add("contacts", seconds.contacts);
  times.add("border edges", seconds.border_edges);
  times.add("crossings", seconds.crossings);
  times.add("depth", seconds.depth);
}

/// Of all that a detection finds.
std::uint64_t hash_of(const Detector& detector) {
  std::uint64_t hash = measure::hash_of(detector.contacts(), fnv1a({}));
  hash = measure::hash_of(detector.edge_contacts(), hash);
  hash = fnv1a(std::as_bytes(std::span(detector.contacts().weights)), hash);
  hash = fnv1a(std::as_bytes(std::span(detector.contacts().certainty)), hash);
  hash = fnv1a(std::as_bytes(detector.border_edges()), hash);
  static_assert(sizeof(Crossing) == 2 * sizeof(Index) + sizeof(double), "no bytes without a value");
  return fnv1a(std::as_bytes(detector.crossings()), hash);
}

[[noreturn]] void fail(const std::string& name, int threads, int frame) {
  throw Error(name, fmt::format("frame {}", frame), fmt::format("another result with {} threads", threads),
              "that of one thread, to the bit");
}

/// With the settings of a user, as "whole detection" is counted.
Json detections(const measure::QueryScene& scene, int frames) {
  const std::vector<int> counts = thread_counts();
  std::deque<Detector> detectors;
  std::deque<FrameTimes> times;
  for (const int threads : counts) {
    detectors.emplace_back(scene.bodies, DetectionSettings{}, scene.immovable(), threads);
    times.emplace_back(threads);
  }
  std::vector<Vec3> positions;
  for (int frame = 0; frame < warm_up + frames; ++frame) {
    scene.place(static_cast<std::uint32_t>(frame), positions);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const Stopwatch watch;
      detectors[i].detect(positions);
      const double seconds = watch.seconds();
      if (hash_of(detectors[i]) != hash_of(detectors[0])) fail(scene.name, counts[i], frame);
      if (frame < warm_up) continue;
      times[i].add("all", seconds);
      add_phases(times[i], detectors[i].times());
    }
  }
  return result(scene.name, scene.bodies.tets().size(), frames, times);
}

Json steps(const std::string& name, const Model& model, const SimulationSettings& settings, int frames) {
  const std::vector<int> counts = thread_counts();
  std::deque<Simulation> simulations;
  std::deque<FrameTimes> times;
  for (const int threads : counts) {
    simulations.emplace_back(model, settings, threads);
    times.emplace_back(threads);
  }
  for (int frame = 0; frame < warm_up + frames; ++frame) {
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const Stopwatch watch;
      simulations[i].step();
      const double seconds = watch.seconds();
      if (simulations[i].state_hash() != simulations[0].state_hash()) fail(name, counts[i], frame);
      if (frame < warm_up) continue;
      const StepMetrics& metrics = simulations[i].metrics();
      times[i].add("all", seconds);
      add_phases(times[i], metrics.detection_seconds);
      times[i].add("forces", metrics.forces_seconds);
      times[i].add("solver", metrics.solver_seconds);
    }
  }
  return result(name, model.bodies.tets().size(), frames, times);
}

}  // namespace

Part threads_part(const SpeedEffort& effort) {
  const int frames = effort.frames_or(usual_frames);
  const int step_frames = effort.frames_or(usual_steps);
  Part part{"threads", {}, threads_rows};
  for (const double tets : {1e4, 102400.0, 1e6}) {
    part.cases.push_back({"whole detection", tets, [=] {
                            return detections(measure::stacking_scene(measure::stacking_cells(tets)), frames);
                          }});
  }
  part.cases.push_back({"falling stack", 1e4, [=] {
                          return steps("falling stack", measure::stacking_model(10), {}, step_frames);
                        }});
  const std::filesystem::path eye = effort.scenes / "eye.json";
  if (std::filesystem::exists(eye)) {
    part.cases.push_back({"eye", 10160, [=] {
                            const Scene scene = read_scene(eye);
                            const auto read = [](const std::filesystem::path& file) {
                              return io::read_mesh(file).mesh;
                            };
                            return steps("eye", load_model(scene, read), scene.settings, frames);
                          }});
  }
  return part;
}

}  // namespace palpate::bench

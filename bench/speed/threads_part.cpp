// Whole detections and whole steps with 1, 2, 4, ... threads, up to the cores of the machine: what the counts
// of instructions_part.cpp predict, by the clock. All thread counts take turns, and must have the same result
// to the bit.
#include <algorithm>
#include <deque>
#include <filesystem>
#include <fmt/format.h>
#include <limits>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/simulation.hpp>

#include "measure/query_scenes.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "stopwatch.hpp"

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

/// The least time of a frame for each of some phases, with one number of threads, ms by the clock. Others on
/// the machine take from the last core first, so a median would say how busy it is.
class LeastTimes {
 public:
  explicit LeastTimes(int threads) : json_{{"threads", threads}} {}
  void take(const char* phase, double seconds) {
    double& least = json_.emplace(phase, std::numeric_limits<double>::max()).first->get_ref<double&>();
    least = std::min(least, 1e3 * seconds);
  }
  [[nodiscard]] const Json& json() const { return json_; }

 private:
  Json json_;
};

Json result(const std::string& name, std::size_t tets, int frames, const std::deque<LeastTimes>& times) {
  Json json{{"name", name}, {"tets", tets}, {"frames", frames}, {"times", Json::array()}};
  for (const LeastTimes& of_count : times) json["times"].push_back(of_count.json());
  return json;
}

void take_phases(LeastTimes& times, const DetectionTimes& seconds) {
  times.take("grid_ms", seconds.grid);
  times.take("contacts_ms", seconds.contacts);
  times.take("border_edges_ms", seconds.border_edges);
  times.take("crossings_ms", seconds.crossings);
  times.take("depth_ms", seconds.depth);
}

bool same(const Detector& a, const Detector& b) {
  const Contacts& of_a = a.contacts();
  const Contacts& of_b = b.contacts();
  return of_a.point == of_b.point && of_a.tet == of_b.tet && of_a.depth == of_b.depth &&
         of_a.direction == of_b.direction && a.edge_contacts().edge == b.edge_contacts().edge &&
         a.edge_contacts().depth == b.edge_contacts().depth;
}

[[noreturn]] void fail(const std::string& name, int threads, int frame) {
  throw Error(name, fmt::format("frame {}", frame), fmt::format("another result with {} threads", threads),
              "that of one thread, to the bit");
}

/// With the settings of a user, as "whole detection" is counted.
Json detections(const measure::QueryScene& scene, int frames) {
  const std::vector<int> counts = thread_counts();
  std::deque<Detector> detectors;
  std::deque<LeastTimes> times;
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
      if (!same(detectors[0], detectors[i])) fail(scene.name, counts[i], frame);
      if (frame < warm_up) continue;
      times[i].take("all_ms", seconds);
      take_phases(times[i], detectors[i].times());
    }
  }
  return result(scene.name, scene.bodies.tets().size(), frames, times);
}

Json steps(const std::string& name, const Model& model, const SimulationSettings& settings, int frames) {
  const std::vector<int> counts = thread_counts();
  std::deque<Simulation> simulations;
  std::deque<LeastTimes> times;
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
      times[i].take("all_ms", seconds);
      take_phases(times[i], metrics.detection_seconds);
      times[i].take("forces_ms", metrics.forces_seconds);
      times[i].take("solver_ms", metrics.solver_seconds);
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

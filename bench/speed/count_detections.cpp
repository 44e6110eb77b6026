// Stores the positions of all detections in the first steps of a scene, and detects them again, in one thread
// and with AVX2, so that callgrind counts the instructions of detections and nothing else.
//
// Usage: palpate-bench-detections record STEPS SCENE FILE [CHANGE...]
//        palpate-bench-detections with|without|times SCENE FILE [CHANGE...]
// The second form detects with or without edge contacts. It prints how many detections there were, and a hash
// of all edge contacts. `times` does both alternately, with the best target of the processor, and prints the
// times in ms and their ratio. callgrind writes its counts of the first detection, which also chooses the
// size of cells, to a file of its own. Called by bench/edges_cost.py, with --instr-atstart=no and
// --collect-atstart=no.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <hwy/targets.h>
#include <ios>
#include <iostream>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <valgrind/callgrind.h>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/io/cell_vectors.hpp>
#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "measure/replay.hpp"
#include "measure/section.hpp"
#include "our_query.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "sim/model_check.hpp"
#include "sim/state_hash.hpp"

namespace palpate::bench {
namespace {

using Frames = std::vector<std::vector<Vec3>>;
constexpr int repeats = 15;

/// Where positions of detections are stored; null: they are not.
Frames* recorded = nullptr;

void record(Model model, const Scene& scene, int steps, const std::string& file) {
  if (scene.relax) relax(model, scene.settings, *scene.relax, 1);
  Frames frames;
  recorded = &frames;
  Simulation simulation(std::move(model), scene.settings, 1);
  for (int step = 0; step < steps; ++step) simulation.step();
  recorded = nullptr;
  std::ofstream out(file, std::ios::binary);
  for (const std::vector<Vec3>& frame : frames) {
    out.write(reinterpret_cast<const char*>(frame.data()),
              static_cast<std::streamsize>(frame.size() * sizeof(Vec3)));
  }
  if (!out.flush()) throw Error(file, "", "no room", "positions written");
  std::cout << frames.size() << " detections\n";
}

/// The positions that record() has stored.
Frames read_frames(const Model& model, const std::string& file) {
  const std::size_t bytes = model.bodies.points_rest().size() * sizeof(Vec3);
  std::ifstream in(file, std::ios::binary);
  const std::string all{std::istreambuf_iterator<char>(in), {}};
  if (all.empty() || all.size() % bytes != 0)
    throw Error(file, "", std::to_string(all.size()) + " bytes", "a multiple of " + std::to_string(bytes));
  Frames frames(all.size() / bytes, std::vector<Vec3>(model.bodies.points_rest().size()));
  for (std::size_t i = 0; i < frames.size(); ++i) std::memcpy(frames[i].data(), &all[i * bytes], bytes);
  return frames;
}

void detect(const Model& model, const DetectionSettings& settings, const Frames& frames) {
  Detector detector(model.bodies, settings, rigid_bodies(model), 1);
  std::uint64_t hash = fnv1a({});
  CALLGRIND_START_INSTRUMENTATION;
  for (const std::vector<Vec3>& positions : frames) {
    CALLGRIND_TOGGLE_COLLECT;
    detector.detect(positions);
    CALLGRIND_TOGGLE_COLLECT;
    if (&positions == frames.data()) CALLGRIND_DUMP_STATS;
    hash = measure::hash_of(detector.edge_contacts(), hash);
  }
  std::cout << frames.size() << " detections, hash of edge contacts " << measure::hash_text(hash) << '\n';
}

/// Processor time of detections of all frames by a new detector, s.
double seconds_of(const Model& model, const DetectionSettings& settings, const Frames& frames) {
  Detector detector(model.bodies, settings, rigid_bodies(model), 1);
  const std::clock_t begin = std::clock();
  for (const std::vector<Vec3>& frame : frames) detector.detect(frame);
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

void compare_times(const Model& model, DetectionSettings settings, const Frames& frames) {
  std::array<std::vector<double>, 2> seconds;
  for (int i = 0; i < repeats; ++i) {
    for (const bool with_edges : {false, true}) {
      settings.edge_contacts = with_edges;
      seconds[with_edges ? 1 : 0].push_back(seconds_of(model, settings, frames));
    }
  }
  for (std::vector<double>& of : seconds) std::ranges::nth_element(of, of.begin() + repeats / 2);
  const double without = seconds[0][repeats / 2];
  const double with = seconds[1][repeats / 2];
  std::cout << frames.size()
            << " detections, ms without edge contacts and with them, ratio: " << 1e3 * without << ' '
            << 1e3 * with << ' ' << with / without << '\n';
}

/// Does what is asked for; false where the usage is wrong.
bool run(std::span<const std::string> words) {
  const std::string mode = words.empty() ? "" : words[0];
  const bool records = mode == "record";
  const std::size_t first = records ? 2 : 1;
  const bool known = records || mode == "with" || mode == "without" || mode == "times";
  if (!known || words.size() < first + 2) return false;
  const Scene scene = read_scene(words[first], words.subspan(first + 2));
  Model model = load_model(
      scene, [](const std::filesystem::path& path) { return io::read_mesh(path).mesh; }, io::read_cell_data);
  if (records) {
    record(std::move(model), scene, std::stoi(words[1]), words[first + 1]);
    return true;
  }
  if (mode == "times") {
    compare_times(model, scene.settings.detection, read_frames(model, words[first + 1]));
    return true;
  }
  const ForcedTarget avx2(HWY_AVX2);
  DetectionSettings settings = scene.settings.detection;
  settings.edge_contacts = mode == "with";
  detect(model, settings, read_frames(model, words[first + 1]));
  return true;
}

}  // namespace
}  // namespace palpate::bench

// The linker leads calls of Detector::detect(positions, fraction) here (--wrap), by these names.
// NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" {
void __real__ZN7palpate8Detector6detectESt4spanIKNS_4Vec3ELm18446744073709551615EEd(
    palpate::Detector*, std::span<const palpate::Vec3>, double);
void __wrap__ZN7palpate8Detector6detectESt4spanIKNS_4Vec3ELm18446744073709551615EEd(
    palpate::Detector* detector, std::span<const palpate::Vec3> positions, double fraction) {
  if (palpate::bench::recorded != nullptr)
    palpate::bench::recorded->emplace_back(positions.begin(), positions.end());
  __real__ZN7palpate8Detector6detectESt4spanIKNS_4Vec3ELm18446744073709551615EEd(detector, positions,
                                                                                 fraction);
}
}
// NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming)

int main(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + argc);
  try {
    if (palpate::bench::run(words)) return 0;
  } catch (const palpate::Error& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
  std::cerr << "usage: palpate-bench-detections record STEPS SCENE FILE [CHANGE...]\n"
               "       palpate-bench-detections with|without|times SCENE FILE [CHANGE...]\n";
  return 2;
}

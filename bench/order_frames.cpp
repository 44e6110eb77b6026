// Detects frame after frame of the stack of membranes in one order of cells, for programs that count what
// that costs (bench/cache_misses.py). Prints how many contacts and crossings it found in all.
//
// Usage: palpate_bench_order linear|z CELLS FRAMES   (CELLS: along a side of the membranes)
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include <palpate/detection.hpp>

#include "measure/query_scenes.hpp"

namespace {

struct Found {
  std::size_t contacts = 0;
  std::size_t crossings = 0;
};

/// A function of its own, so that counting can begin and end with it.
[[gnu::noinline]] Found counted_frames(palpate::Detector& detector, const palpate::measure::QueryScene& scene,
                                       std::uint32_t first, std::uint32_t frames) {
  Found found;
  std::vector<palpate::Vec3> positions;
  for (std::uint32_t f = first; f < first + frames; ++f) {
    scene.place(f, positions);
    detector.detect(positions);
    found.contacts += detector.contacts().size();
    found.crossings += detector.crossings().size();
  }
  return found;
}

int work(const std::string& order, int cells, std::uint32_t frames) {
  const palpate::measure::QueryScene scene = palpate::measure::stacking_scene(cells);
  palpate::DetectionSettings settings;
  settings.order = order == "z" ? palpate::Order::z : palpate::Order::linear;
  palpate::Detector detector(scene.bodies, settings, scene.immovable(), 1);
  std::vector<palpate::Vec3> positions;
  constexpr std::uint32_t warm_up = 2;
  for (std::uint32_t f = 0; f < warm_up; ++f) {
    scene.place(f, positions);
    detector.detect(positions);
  }
  const Found found = counted_frames(detector, scene, warm_up, frames);
  std::cout << found.contacts << ' ' << found.crossings << '\n';
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string order = argc == 4 ? argv[1] : "";
  if (order != "linear" && order != "z") {
    std::cerr << "usage: palpate_bench_order linear|z CELLS FRAMES\n";
    return 2;
  }
  return work(order, std::atoi(argv[2]), static_cast<std::uint32_t>(std::atoi(argv[3])));
}

// Saved states: as they are, and as content of a state that is sealed and of the right simulation, so that
// the checksum does not keep the fuzzer out.
#include <algorithm>
#include <vector>

#include <palpate/simulation.hpp>

#include "fuzz/fuzzing.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "sim/archive.hpp"
#include "sim/saved_state.hpp"

namespace {

using namespace palpate;

constexpr const char* scene_text =
    R"({"time_step": 0.01, "duration": 1, "contact": {"friction": 0.3}, "bodies": [
  {"name": "plate", "box": {"cells": [1, 1, 1], "size": [0.2, 0.2, 0.02]}, "translate": [0, 0, -0.01], "obstacle": true},
  {"name": "box", "box": {"cells": [1, 1, 1], "size": [0.06, 0.06, 0.02]}, "translate": [0, 0, 0.009],
   "material": {"young_modulus": 20000, "plastic_yield": 0.01, "plastic_creep": 5}}]})";

Simulation make_simulation() {
  const Scene scene = read_scene_text(scene_text, "fuzz");
  Model model = load_model(scene, [](const std::filesystem::path&) { return TetMesh{}; });
  return Simulation(std::move(model), scene.settings, 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Simulation simulation = make_simulation();
  static const std::vector<std::byte> start = simulation.save();
  const auto bytes = std::as_bytes(std::span(data, size));
  fuzz::refusing([&] { simulation.restore(bytes); });

  constexpr std::size_t head = 12;  // kind and version
  constexpr std::size_t fingerprint = sizeof(Fingerprint::hashes);
  std::vector<std::byte> content(start.begin() + head, start.begin() + head + fingerprint);
  content.insert(content.end(), bytes.begin(), bytes.end());
  fuzz::refusing([&] {
    simulation.restore(sealed({.kind = "PALPSTAT", .version = 2}, content));
    simulation.step();
  });
  simulation.restore(start);
  fuzz::require(simulation.save() == start);
  return 0;
}

// Saved states: as files; as content with a valid checksum and fingerprint, so that these do not stop the
// fuzzer; and as changes of single bytes of a state saved in contact.
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

std::vector<std::byte> content_of(std::span<const std::byte> state) {
  const std::span<const std::byte> content = unsealed(state_seal, state, "fuzz");
  return {content.begin(), content.end()};
}

/// Each three bytes of the input: the third is stored at the index given by the first two.
std::vector<std::byte> changed(std::vector<std::byte> content, std::span<const std::byte> input) {
  for (std::size_t i = 0; i + 2 < input.size(); i += 3) {
    const std::size_t place =
        std::to_integer<std::size_t>(input[i]) + 256 * std::to_integer<std::size_t>(input[i + 1]);
    content[place % content.size()] = input[i + 2];
  }
  return content;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Simulation simulation = make_simulation();
  static const std::vector<std::byte> start = simulation.save();
  static const std::vector<std::byte> in_contact = [] {
    for (int step = 0; step < 12; ++step) simulation.step();
    fuzz::require(simulation.metrics().detection.contacts > 0);
    return content_of(simulation.save());
  }();
  const auto bytes = std::as_bytes(std::span(data, size));
  simulation.restore(start);
  fuzz::refusing([&] { simulation.restore(bytes); });

  const auto go_on = [](std::span<const std::byte> content) {
    fuzz::refusing([&] {
      simulation.restore(sealed(state_seal, content));
      simulation.step();
    });
    simulation.restore(start);
    fuzz::require(simulation.save() == start);
  };
  static const std::vector<std::byte> first = content_of(start);
  std::vector<std::byte> content(first.begin(), first.begin() + sizeof(Fingerprint::hashes));
  content.insert(content.end(), bytes.begin(), bytes.end());
  go_on(content);
  go_on(changed(in_contact, bytes));
  return 0;
}

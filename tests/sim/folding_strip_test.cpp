// A strip falls over and folds onto itself. Oracles: half its thickness as the bound of self-contact, and the
// same run without self-collision, which goes through.
#include <algorithm>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"

namespace palpate {
namespace {

constexpr double half_thickness = 0.006;  // of the strip, scenes/folding-strip.json
constexpr Index strip_body = 1;

Simulation strip(bool self_collision, int threads, Structure structure = Structure::compact) {
  Scene scene = read_scene(PALPATE_SOURCE_DIR "/scenes/folding-strip.json");
  if (!self_collision) scene.settings.detection.self_collision.clear();
  scene.settings.detection.structure = structure;
  Model model = load_model(scene, [](const std::filesystem::path& path) -> TetMesh {
    throw Error(path.string(), "", "a mesh file", "none in this scene");
  });
  return Simulation(std::move(model), scene.settings, threads);
}

struct SelfContacts {
  std::size_t count = 0;
  double deepest = 0.0;
};

SelfContacts self_contacts(const Simulation& simulation, const Detector& detector) {
  SelfContacts found;
  const Contacts& contacts = detector.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (at(simulation.bodies().body_of_point(), contacts.point[c]) != strip_body ||
        contacts.body[c] != strip_body)
      continue;
    ++found.count;
    found.deepest = std::max(found.deepest, contacts.depth[c]);
  }
  return found;
}

TEST(FoldingStrip, ComesToRestOnItselfWithoutPassingThrough) {
  Simulation simulation = strip(true, 2);
  while (!simulation.at_rest() && simulation.metrics().time < 6.0) {
    simulation.step();
    ASSERT_LT(self_contacts(simulation, simulation.detector()).deepest, half_thickness)
        << "at " << simulation.metrics().time << " s";
  }
  EXPECT_TRUE(simulation.at_rest());
  const SelfContacts at_rest = self_contacts(simulation, simulation.detector());
  EXPECT_GT(at_rest.count, 30U) << "it lies on itself";
  EXPECT_LT(4 * simulation.metrics().detection.folded_pairs, at_rest.count) << "but in its sharpest bends";
  EXPECT_LT(at_rest.deepest, 0.4 * half_thickness);
}

TEST(FoldingStrip, PassesThroughItselfWithoutSelfCollision) {
  Simulation simulation = strip(false, 2);
  DetectionSettings settings;
  settings.self_collision = {0, 1};
  Detector look(simulation.bodies(), settings, {1, 0}, 2);
  double deepest = 0.0;
  while (!simulation.at_rest() && simulation.metrics().time < 6.0) {
    simulation.step();
    look.detect(simulation.positions());
    deepest = std::max(deepest, self_contacts(simulation, look).deepest);
  }
  EXPECT_GT(deepest, 0.9 * half_thickness) << "what the other test must not see";
}

TEST(FoldingStrip, HasTheSameHashForEveryThreadCountAndStructure) {
  std::string expected;
  int threads = 0;
  for (const Structure structure :
       {Structure::compact, Structure::uniform, Structure::hash, Structure::cuckoo, Structure::brute}) {
    Simulation simulation = strip(true, ++threads, structure);
    for (int i = 0; i < 60; ++i) simulation.step();
    EXPECT_GT(self_contacts(simulation, simulation.detector()).count, 20U);
    if (expected.empty()) expected = simulation.state_hash();
    EXPECT_EQ(simulation.state_hash(), expected) << structure_names[static_cast<std::size_t>(structure)];
  }
}

}  // namespace
}  // namespace palpate

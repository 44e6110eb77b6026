// Oracle: the run that was not interrupted.
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <vector>

#include "sim/archive.hpp"
#include "sim/examples.hpp"
#include "sim/state_hash.hpp"

namespace palpate::test {
namespace {

using Bytes = std::vector<std::byte>;

void run_steps(Simulation& simulation, int count) {
  for (int i = 0; i < count; ++i) simulation.step();
}

Scene with_structure(const Scene& scene, Structure structure) {
  Scene other = scene;
  other.settings.detection.structure = structure;
  return other;
}

/// A state with changed content and a valid checksum.
Bytes changed(Bytes bytes, std::size_t place, std::uint64_t value) {
  std::memcpy(bytes.data() + place, &value, std::min(sizeof value, bytes.size() - 8 - place));
  const std::uint64_t hash = fnv1a(std::span(bytes).first(bytes.size() - 8));
  std::memcpy(bytes.data() + bytes.size() - 8, &hash, 8);
  return bytes;
}

void expect_refused(Simulation& simulation, std::span<const std::byte> bytes, const std::string& part) {
  const Bytes before = simulation.save();
  try {
    simulation.restore(bytes);
    ADD_FAILURE() << "taken, expected an error with: " << part;
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
  EXPECT_EQ(simulation.save(), before);
}

/// Saved after some steps, at moments of all kinds: before, during and after the first contacts.
class Checkpoint : public ::testing::TestWithParam<const char*> {};

TEST_P(Checkpoint, GoesOnWithTheSameBitsAndTellsTheSame) {
  const Scene scene = example(GetParam());
  for (const int first : {0, 1, 17, 60}) {
    Simulation whole = simulate(scene);
    run_steps(whole, first);
    const Bytes saved = whole.save();
    Simulation resumed = simulate(scene, 1);
    run_steps(resumed, 3);
    resumed.restore(saved);
    EXPECT_EQ(resumed.save(), saved);
    EXPECT_EQ(resumed.metrics().detection.contacts, whole.metrics().detection.contacts);
    run_steps(whole, 25);
    run_steps(resumed, 25);
    EXPECT_EQ(resumed.state_hash(), whole.state_hash()) << "saved after " << first;
    EXPECT_EQ(resumed.save(), whole.save()) << "all that is remembered, and all counts";
  }
}

TEST_P(Checkpoint, TheStructureMayChange) {
  const Scene scene = example(GetParam());
  Simulation whole = simulate(scene);
  run_steps(whole, 30);
  const Bytes saved = whole.save();
  run_steps(whole, 20);
  for (const Structure structure : {Structure::hash, Structure::cuckoo, Structure::uniform}) {
    Simulation resumed = simulate(with_structure(scene, structure), 3);
    resumed.restore(saved);
    run_steps(resumed, 20);
    EXPECT_EQ(resumed.state_hash(), whole.state_hash());
  }
}

INSTANTIATE_TEST_SUITE_P(Examples, Checkpoint,
                         ::testing::Values("everything", "belt", "plastic", "fold", "grab", "tower"),
                         [](const auto& value) { return std::string(value.param); });

TEST(CheckpointOf, StressThatRelaxesIsInIt) {
  Scene scene = example("plastic");
  for (SceneBody& body : scene.bodies) {
    if (body.material) body.material->viscosity = {.fractions = {0.4, 0.2}, .times = {0.02, 0.5}};
  }
  Simulation whole = simulate(scene);
  run_steps(whole, 30);
  Simulation resumed = simulate(scene, 3);
  resumed.restore(whole.save());
  EXPECT_EQ(resumed.save(), whole.save());
  run_steps(whole, 20);
  run_steps(resumed, 20);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
  EXPECT_EQ(resumed.save(), whole.save());
  // Without plasticity the tissue behaves differently.
  Simulation elastic = simulate(example("plastic"));
  expect_refused(elastic, whole.save(), "materials");
  run_steps(elastic, 50);
  EXPECT_NE(elastic.state_hash(), whole.state_hash());
}

TEST(CheckpointOf, LoadsGrabsAndTheirForcesAreInIt) {
  const Scene scene = example("grab");
  const auto begin = [&](Simulation& simulation) {
    const Index tissue = simulation.bodies().bodies().back().points.begin;
    simulation.set_force(tissue + 3, {0.0, 0.1, 0.0});
    const Index number = simulation.grab({.point = tissue + 5, .target = {0.1, 0.0, 0.3}, .stiffness = 40.0});
    run_steps(simulation, 10);
    return number;
  };
  Simulation whole = simulate(scene);
  const Index number = begin(whole);
  Simulation resumed = simulate(scene);
  resumed.restore(whole.save());
  EXPECT_EQ(resumed.grab_force(number), whole.grab_force(number));
  run_steps(whole, 10);
  run_steps(resumed, 10);
  EXPECT_EQ(resumed.save(), whole.save());
  resumed.release(number);
  EXPECT_THROW(static_cast<void>(resumed.grab_force(number)), Error);
}

/// The top of a tet goes through its base, which is fixed, faster than it can spring back.
TEST(CheckpointOf, InvertedTetsAreCountedAgain) {
  const auto begin = [] {
    Model model;
    model.bodies.add("tet", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}});
    model.materials = {{1000.0}};
    model.fixed_points = {1, 1, 1, 0};
    model.velocities = {{}, {}, {}, {0, 0, -150}};
    SimulationSettings settings;
    settings.gravity = {};
    return Simulation(model, settings, 1);
  };
  Simulation whole = begin();
  EXPECT_EQ(whole.metrics().inverted_tets, 0);
  run_steps(whole, 1);
  EXPECT_LT(whole.positions()[3].z, 0.0);
  EXPECT_EQ(whole.metrics().inverted_tets, 1);
  Simulation resumed = begin();
  resumed.restore(whole.save());
  EXPECT_EQ(resumed.metrics().inverted_tets, 1);
}

TEST(CheckpointOf, ApproximateModeLeavesOutTheSameCells) {
  Scene scene = example("everything");
  scene.settings.detection.cells_per_primitive = 2;
  Simulation whole = simulate(scene);
  run_steps(whole, 20);
  Simulation resumed = simulate(scene);
  resumed.restore(whole.save());
  run_steps(whole, 20);
  run_steps(resumed, 20);
  EXPECT_GT(whole.metrics().detection.dropped_cells, 0U);
  EXPECT_EQ(resumed.save(), whole.save());
}

TEST(CheckpointOf, TheQueueOfABudgetIsInIt) {
  Scene scene = example("everything");
  scene.settings.detection.budget = Budget{.tests = 4000};
  Simulation whole = simulate(scene);
  run_steps(whole, 20);
  EXPECT_LT(whole.metrics().detection.completeness, 1.0);
  const Bytes saved = whole.save();
  Simulation resumed = simulate(scene, 3);
  resumed.restore(saved);
  EXPECT_EQ(resumed.save(), saved);
  run_steps(whole, 20);
  run_steps(resumed, 20);
  EXPECT_EQ(resumed.save(), whole.save());
}

TEST(CheckpointOf, ABudgetWithoutPressureChangesNoBit) {
  const Scene scene = example("everything");
  Scene limited = scene;
  Simulation exact = simulate(scene);
  run_steps(exact, 60);
  for (const Budget& budget :
       {Budget{.tests = std::numeric_limits<int>::max()}, Budget{.milliseconds = 1e6}}) {
    limited.settings.detection.budget = budget;
    Simulation simulation = simulate(limited);
    run_steps(simulation, 60);
    EXPECT_EQ(simulation.state_hash(), exact.state_hash());
  }
}

TEST(CheckpointOf, AStepThatFailedLeavesAStateThatGoesOn) {
  Scene scene = example("tower");
  Simulation whole = simulate(scene);
  run_steps(whole, 10);
  const Bytes good = whole.save();
  const auto last = static_cast<Index>(whole.positions().size()) - 1;
  whole.set_force(last, {0.0, 0.0, std::numeric_limits<double>::max()});
  EXPECT_THROW(whole.step(), Error);
  Simulation resumed = simulate(scene);
  resumed.restore(good);
  whole.set_force(last, {});
  run_steps(whole, 10);
  run_steps(resumed, 10);
  EXPECT_EQ(resumed.state_hash(), whole.state_hash());
}

TEST(CheckpointOf, AnotherSimulationIsRefused) {
  const Scene scene = example("tower");
  Simulation simulation = simulate(scene);
  run_steps(simulation, 3);
  const Bytes saved = simulation.save();
  const auto refused_by = [&](const Scene& other, const std::string& part) {
    Simulation another = simulate(other);
    expect_refused(another, saved, part);
  };
  refused_by(example("belt"), "bodies");
  Scene other = scene;
  other.bodies.back().material->young_modulus *= 2.0;
  refused_by(other, "materials");
  other = scene;
  other.settings.time_step *= 0.5;
  refused_by(other, "settings");
  other = scene;
  other.settings.response.friction += 0.1;
  refused_by(other, "settings");
}

TEST(CheckpointOf, EveryCutAndEveryChangedByteIsRefused) {
  Simulation simulation = simulate(example("press"));
  run_steps(simulation, 30);
  const Bytes saved = simulation.save();
  ASSERT_GT(simulation.metrics().detection.contacts, 0U);
  for (std::size_t size = 0; size < saved.size(); size += 1 + saved.size() / 97)
    expect_refused(simulation, std::span(saved).first(size), "saved state");
  for (std::size_t place = 0; place < saved.size(); place += 1 + saved.size() / 97) {
    Bytes damaged = saved;
    damaged[place] ^= std::byte{1};
    expect_refused(simulation, damaged, "saved state");
  }
}

/// Content that no simulation saves, with a valid checksum: refused, or harmless.
TEST(CheckpointOf, NoContentDoesHarm) {
  const Scene scene = example("press");
  Simulation simulation = simulate(scene);
  run_steps(simulation, 30);
  const Bytes saved = simulation.save();
  int refused = 0;
  for (std::size_t place = 12; place + 16 < saved.size(); place += 8 + saved.size() / 149) {
    for (const std::uint64_t value :
         {~std::uint64_t{0}, std::uint64_t{0x7ff0000000000000}, std::uint64_t{1} << 40U}) {
      Simulation target = simulate(scene, 1);
      try {
        target.restore(changed(saved, place, value));
        target.step();
      } catch (const Error&) {
        ++refused;
      }
    }
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace palpate::test

// The same final state for every way to find contacts and every number of threads, on the scene that uses all
// that contact handling and dynamics can do. Oracle: equality of bits, and for each capability that the scene
// ends otherwise without it.
#include <functional>

#include "contact/variants.hpp"
#include "sim/examples.hpp"

namespace palpate::test {
namespace {

SceneBody& body_of(Scene& scene, const std::string& name) {
  for (SceneBody& body : scene.bodies) {
    if (body.name == name) return body;
  }
  throw Error("examples", name, "no such body", "the name of a body");
}

TEST(Everything, ActsInTheScene) {
  Simulation simulation = simulate(example("everything"));
  run_to(simulation, 0.3);
  EXPECT_LT(centre(simulation, "block").x, 0.049) << "the load made it slide";
  EXPECT_GT(length(force_on(simulation, "jaw")), 1.0) << "the jaw has closed";
  EXPECT_GT(length(simulation.grab_force(0)), 0.05);
  run_to(simulation, 1.2);
  EXPECT_GT(self_contacts(simulation).count, 5U);
  EXPECT_LT(self_contacts(simulation).deepest, 0.002);

  const std::string hash = simulation.state_hash();
  const std::vector<std::pair<std::string, std::function<void(Scene&)>>> changes{
      {"a motion", [](Scene& s) { body_of(s, "jaw").motion->keyframes.resize(1); }},
      {"attachment", [](Scene& s) { body_of(s, "strip").attached.clear(); }},
      {"self-collision",
       [](Scene& s) {
         body_of(s, "strip").self_collision = false;
         s.settings.detection.self_collision.clear();
       }},
      {"plasticity", [](Scene& s) { body_of(s, "cushion").material->plastic_yield.reset(); }},
      {"regions", [](Scene& s) { body_of(s, "cushion").regions.clear(); }},
      {"the grab", [](Scene& s) { body_of(s, "ball").grabs.clear(); }},
      {"the load", [](Scene& s) { body_of(s, "block").loads.clear(); }},
      {"friction", [](Scene& s) { s.settings.response.friction = 0.0; }}};
  for (const auto& [what, change] : changes) {
    Scene scene = example("everything");
    change(scene);
    EXPECT_NE(run(scene).state_hash(), hash) << "without " << what;
  }
}

TEST(Everything, PlasticStrainStaysWhenTheJawOpens) {
  Scene scene = example("everything");
  const double dented = heights(run(scene), "cushion").highest;
  body_of(scene, "cushion").material->plastic_yield.reset();
  EXPECT_LT(dented, heights(run(scene), "cushion").highest - 0.001);
}

class EverythingOn : public testing::TestWithParam<int> {};

/// Brute force included.
TEST_P(EverythingOn, EndsTheSameForEveryStructureOrderAndSort) {
  const std::string expected = run(example("everything"), 1).state_hash();
  std::size_t runs = 0;
  for (const DetectionSettings& variant : every_variant()) {
    Scene scene = example("everything");
    scene.settings.detection.structure = variant.structure;
    scene.settings.detection.order = variant.order;
    scene.settings.detection.sort = variant.sort;
    EXPECT_EQ(run(scene, GetParam()).state_hash(), expected) << name_of(variant);
    ++runs;
  }
  EXPECT_EQ(runs, 16U);
}

INSTANTIATE_TEST_SUITE_P(Threads, EverythingOn, testing::Values(1, 2, 3, 5),
                         testing::PrintToStringParamName());

}  // namespace
}  // namespace palpate::test

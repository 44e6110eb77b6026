// Every scene of examples/scenes runs, is in docs/gallery.md, and shows the effect stated there. Oracles:
// statics and dynamics by hand, and the same scene without the feature that it shows.
#include "sim/examples.hpp"

#include <algorithm>
#include <fstream>
#include <numbers>
#include <sstream>

namespace palpate::test {
namespace {

std::vector<std::string> example_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(example_folder())) {
    if (entry.path().extension() == ".json") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class EveryExample : public testing::TestWithParam<std::string> {};

TEST_P(EveryExample, RunsAFewSteps) {
  const Scene scene = example(GetParam());
  EXPECT_EQ(scene.name, GetParam()) << "results and pictures go by the name";
  Simulation simulation = simulate(scene);
  EXPECT_LE(simulation.bodies().tets().size(), 1500U);
  EXPECT_LE(scene.duration, 2.0);
  Vec3 lower{INFINITY, INFINITY, INFINITY};
  Vec3 upper = -lower;
  for (const Vec3& p : simulation.positions()) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  const Vec3 middle = 0.5 * (lower + upper);
  const double size = length(upper - lower);
  for (int i = 0; i < 20; ++i) {
    simulation.step();
    for (const Vec3& p : simulation.positions()) ASSERT_LT(length(p - middle), size) << "step " << i + 1;
    // The point pulled by a spring is the fastest. Bound: twice the speed of free fall from the height of the
    // scene.
    ASSERT_LT(simulation.metrics().largest_speed, 2.0 * std::sqrt(2.0 * 9.81 * size)) << "step " << i + 1;
  }
}

/// Sums over the triangles of a body: force, torque about a point, and absolute force.
struct SurfaceSums {
  Vec3 force;
  Vec3 torque;
  double size = 0.0;
};
SurfaceSums sums_over(const Simulation& simulation, const SurfaceTractions& surface, Index body,
                      const Vec3& about) {
  SurfaceSums sums;
  const Bodies& bodies = simulation.bodies();
  const Range range = at(bodies.bodies(), body).triangles;
  for (Index t = range.begin; t < range.end; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& f = at(surface.corner_forces, t)[k];
      sums.force += f;
      sums.torque += cross(at(simulation.positions(), at(bodies.triangles(), t)[k]) - about, f);
      sums.size += length(f);
    }
  }
  return sums;
}

/// Also in motion, when a point in contact has left its tet by the end of the step.
TEST_P(EveryExample, HasTractionsThatAddUpToTheWrenchOfEachBody) {
  Simulation simulation = simulate(example(GetParam()));
  const Vec3 about{0.03, 0.02, -0.01};
  for (int step = 0; step < 60; ++step) {
    simulation.step();
    const SurfaceTractions surface = simulation.tractions();
    for (Index body = 0; body < simulation.bodies().body_count(); ++body) {
      const SurfaceSums sums = sums_over(simulation, surface, body, about);
      const Wrench expected = simulation.contact_wrench(body, about);
      ASSERT_LE(length(sums.force - expected.force), 1e-9 * sums.size) << "step " << step << ", " << body;
      ASSERT_LE(length(sums.torque - expected.torque), 1e-9 * sums.size) << "step " << step << ", " << body;
    }
  }
}

TEST_P(EveryExample, IsInTheGallery) {
  std::stringstream gallery;
  gallery << std::ifstream(PALPATE_SOURCE_DIR "/docs/gallery.md").rdbuf();
  EXPECT_NE(gallery.str().find("(gallery/" + GetParam() + ".png)"), std::string::npos);
  EXPECT_NE(gallery.str().find("run examples/scenes/" + GetParam() + ".json"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Examples, EveryExample, testing::ValuesIn(example_names()), [](const auto& example) {
  std::string name = example.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

TEST(Examples, AttachedTissueFollowsItsBoneAndBendsOverTheRod) {
  const Simulation simulation = run(example("attached"));
  const Range bar = points_of(simulation, "bar");
  int glued = 0;
  for (Index p = bar.begin; p < bar.end; ++p) {
    const Vec3 start = at(simulation.bodies().points_rest(), p);
    if (std::abs(start.x) > 1e-9) continue;
    ++glued;
    EXPECT_LT(length(at(simulation.positions(), p) - (start - Vec3{0, 0, 0.07})), 1e-12);
  }
  EXPECT_EQ(glued, 5 * 3);
  EXPECT_LT(force_on(simulation, "rod").z, 0.0);
  EXPECT_GT(height_at(simulation, "bar", 0.16), height_at(simulation, "bar", 0.0) + 0.04);
  EXPECT_TRUE(simulation.at_rest());
}

TEST(Examples, ABeltTakesTheBlockAlongAndSlidesUnderItWhenItMeetsTheStop) {
  Simulation simulation = simulate(example("belt"));
  run_to(simulation, 0.3);
  EXPECT_NEAR(velocity(simulation, "block").x, 0.3, 0.003);
  EXPECT_EQ(force_on(simulation, "stop").x, 0.0);
  run_to(simulation, 1.0);
  EXPECT_LT(length(velocity(simulation, "block")), 0.002);
  const Vec3 belt = force_on(simulation, "belt");
  const Vec3 stop = force_on(simulation, "stop");
  EXPECT_NEAR(belt.x, 0.4 * belt.z, -0.005 * belt.z) << "slides";
  EXPECT_NEAR(stop.x, -belt.x, 0.005 * stop.x);
  // The block leans on the stop, whose friction, at most 0.4 of the push, presses it down a little.
  const double weight = weight_of(simulation, "block");
  EXPECT_NEAR(-belt.z, weight + stop.z, 0.005 * weight);
  EXPECT_GT(stop.z, 0.0);
  EXPECT_LT(stop.z, 0.401 * stop.x);
}

TEST(Examples, BarsThatCrossEdgeOnEdgeRestOnEachOther) {
  Scene scene = example("crossed-bars");
  Simulation simulation = simulate(scene);
  while (simulation.metrics().time < scene.duration - 1e-9) {
    simulation.step();
    ASSERT_EQ(simulation.detector().contacts().size(), 0U) << "step " << simulation.metrics().step;
  }
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_GE(simulation.detector().edge_contacts().size(), 4U) << "two edges of each bar";
  const double weight = weight_of(simulation, "upper");
  EXPECT_LT(length(force_on(simulation, "upper") - Vec3{0, 0, weight}), 0.001 * weight);
  EXPECT_LT(length(force_on(simulation, "lower") + Vec3{0, 0, weight}), 0.001 * weight);
  EXPECT_LT(length(centre(simulation, "upper") - centre(simulation, "lower") - Vec3{0, 0, 0.02}), 0.01)
      << "a bar is 0.02 thick; both bend down";
  scene.settings.detection.edge_contacts = false;
  const Simulation falls = run(scene);
  EXPECT_LT(centre(falls, "upper").z, -1.0);
  EXPECT_NEAR(centre(falls, "lower").z, 0.0, 0.002) << "its own weight";
}

TEST(Examples, AFoldedStripLiesOnItself) {
  Simulation simulation = simulate(example("fold"));
  while (simulation.metrics().time < 2.0 - 1e-9) {
    simulation.step();
    ASSERT_LT(self_contacts(simulation).deepest, 0.005)
        << "half of the strip, step " << simulation.metrics().step;
    ASSERT_EQ(simulation.metrics().detection.folded_pairs, 0U) << "step " << simulation.metrics().step;
  }
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_GT(self_contacts(simulation).count, 5U);
  EXPECT_LT(self_contacts(simulation).deepest, 0.001) << "a tenth of the strip";
  Scene scene = example("fold");
  scene.bodies.at(2).self_collision = false;
  scene.settings.detection.self_collision.clear();
  EXPECT_LT(height_at(run(scene), "strip", 0.06), height_at(simulation, "strip", 0.06) - 0.003)
      << "it would sink into itself";
}

TEST(Examples, AGrabHoldsTheBallByItsWeight) {
  const Scene scene = example("grab");
  const Simulation simulation = run(scene);
  const SceneGrab& grab = scene.bodies.at(1).grabs.at(0);
  const double weight = weight_of(simulation, "ball");
  const Vec3 force = simulation.grab_force(0);
  EXPECT_NEAR(force.z, weight, 0.01 * weight);
  const double pulled = heights(simulation, "ball").highest;  // the point that the spring holds
  EXPECT_NEAR(grab.stiffness * (grab.target.z - pulled), weight, 0.01 * weight);
  EXPECT_GT(heights(simulation, "ball").lowest, 0.03) << "off the plate";
}

TEST(Examples, ABlockSticksBelowTheAngleOfFrictionAndSlidesAboveIt) {
  Simulation sticks = simulate(example("incline-stick"));
  const double start = centre(sticks, "block").x;
  run_to(sticks, 1.0);
  EXPECT_NEAR(centre(sticks, "block").x, start, 0.001);
  EXPECT_LT(length(velocity(sticks, "block")), 1e-5);

  Simulation slides = simulate(example("incline-slide"));
  run_to(slides, 0.2);
  const double before = length(velocity(slides, "block"));
  run_to(slides, 0.6);
  const double angle = 20.0 * std::numbers::pi / 180.0;
  const double expected = 9.81 * (std::sin(angle) - 0.2 * std::cos(angle));
  EXPECT_NEAR((length(velocity(slides, "block")) - before) / 0.4, expected, 0.05 * expected);
}

/// Every step of a run converges and inverts no tet.
Simulation run_cleanly(const Scene& scene) {
  Simulation simulation = simulate(scene);
  while (simulation.metrics().time < scene.duration - 1e-9) {
    simulation.step();
    EXPECT_TRUE(simulation.metrics().solver_converged) << "step " << simulation.metrics().step;
    EXPECT_EQ(simulation.metrics().inverted_tets, 0U) << "step " << simulation.metrics().step;
  }
  return simulation;
}

TEST(Examples, ALiverIsSqueezedBy40Percent) {
  const Simulation simulation = run_cleanly(example("liver"));
  EXPECT_NEAR(heights(simulation, "liver").highest - heights(simulation, "liver").lowest, 0.6 * 0.08, 0.0005);
  const Vec3 lower = force_on(simulation, "lower");
  const Vec3 upper = force_on(simulation, "upper");
  EXPECT_LT(lower.z, 0.0);
  EXPECT_NEAR(upper.z, -lower.z, 0.01 * upper.z) << "there is no gravity";
}

/// Active tension holds the weight at its end; the same muscle without it does not.
TEST(Examples, AMuscleContractsAndThickens) {
  const auto extent = [](const Simulation& simulation) {
    Vec3 lower{INFINITY, INFINITY, INFINITY};
    Vec3 upper = -lower;
    for (const Vec3& p : simulation.positions()) {
      lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
      upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
    }
    return upper - lower;
  };
  Scene scene = example("muscle");
  const Vec3 active = extent(run_cleanly(scene));
  scene.bodies.at(0).material->fibres.activation.factors = {0.0, 0.0};
  const Vec3 passive = extent(run(scene));
  EXPECT_GT(passive.x, 0.2) << "the load stretches it";
  EXPECT_LT(active.x, 0.75 * passive.x);
  EXPECT_GT(active.y, 1.15 * passive.y);
  EXPECT_NEAR(active.y, active.z, 0.02 * active.y) << "round as before";
}

TEST(Examples, AJawPressesTheBlockOntoThePlate) {
  const Simulation simulation = run(example("jaw"));
  EXPECT_TRUE(simulation.at_rest());
  const double weight = weight_of(simulation, "block");
  const double bite = force_on(simulation, "jaw").z;
  EXPECT_GT(bite, 5.0 * weight);
  EXPECT_NEAR(-force_on(simulation, "plate").z, bite + weight, 0.01 * bite);
  EXPECT_NEAR(force_on(simulation, "plate").x, -force_on(simulation, "jaw").x, 0.01 * bite)
      << "friction of the plate holds what the slanted jaw pushes out";
}

/// Least height of a point of the needle above the middle of the sheet.
double height_above_sheet(const Simulation& simulation) {
  const Range needle = points_of(simulation, "needle");
  const Range sheet = points_of(simulation, "sheet");
  const double thickness = 0.002;
  double least = INFINITY;
  for (Index n = needle.begin; n < needle.end; ++n) {
    const Vec3& point = at(simulation.positions(), n);
    double nearest = INFINITY;
    double height = 0.0;
    for (Index s = sheet.begin; s < sheet.end; ++s) {
      if (at(simulation.bodies().points_rest(), s).z > 0.0) continue;  // of the upper side
      const Vec3& below = at(simulation.positions(), s);
      const double distance = std::hypot(point.x - below.x, point.y - below.y);
      if (distance >= nearest) continue;
      nearest = distance;
      height = point.z - (below.z + 0.5 * thickness);
    }
    least = std::min(least, height);
  }
  return least;
}

TEST(Examples, ANeedleThatWouldJumpOverTheSheetIsStoppedByIt) {
  Scene scene = example("needle");
  Simulation simulation = simulate(scene);
  std::int64_t stopped = 0;
  while (simulation.metrics().time < scene.duration - 1e-9) {
    simulation.step();
    ASSERT_GT(height_above_sheet(simulation), 0.0) << "step " << simulation.metrics().step;
    ASSERT_EQ(simulation.metrics().passes, 0) << "step " << simulation.metrics().step;
    stopped += simulation.metrics().stopped_passes;
  }
  EXPECT_GT(stopped, 0);
  EXPECT_TRUE(simulation.at_rest());
  const double weight = weight_of(simulation, "needle");
  EXPECT_LT(length(force_on(simulation, "needle") - Vec3{0, 0, weight}), 0.001 * weight);
  EXPECT_LT(heights(simulation, "needle").extent(), 0.008) << "it lies flat, 0.004 thick and 0.032 long";

  scene.settings.detection.continuous = ContinuousDetection::off;
  Simulation jumps = simulate(scene);
  run_to(jumps, 0.01);
  const Heights before = heights(jumps, "needle");
  jumps.step();
  const Heights after = heights(jumps, "needle");
  EXPECT_GT(before.lowest - after.highest, 0.002) << "in one step by more than its length and the sheet";
  while (jumps.metrics().time < 0.1 - 1e-9) {
    jumps.step();
    EXPECT_EQ(jumps.detector().contacts().size(), 0U);
    EXPECT_EQ(jumps.detector().edge_contacts().size(), 0U);
  }
  EXPECT_LT(heights(jumps, "needle").highest, -0.2) << "far below the sheet";
}

TEST(Examples, ThePlateFeelsTheLoadAndTheWeight) {
  const Simulation simulation = run(example("load"));
  const double weight = weight_of(simulation, "column");
  const Vec3 felt = force_on(simulation, "plate");
  EXPECT_LT(length(felt - Vec3{0.6, 0, -0.5 - weight}), 0.01 * weight);
  EXPECT_GT(centre(simulation, "column").x, 0.002) << "it leans";
  EXPECT_TRUE(simulation.at_rest());
}

TEST(Examples, ABarThatYieldedStaysBent) {
  const auto sag = [](const Simulation& simulation) {
    return 0.5 * (height_at(simulation, "bar", -0.08) + height_at(simulation, "bar", 0.08)) -
           height_at(simulation, "bar", 0.0);
  };
  const Simulation yields = run(example("plastic"));
  EXPECT_EQ(force_on(yields, "punch"), Vec3{}) << "the punch is away";
  Scene scene = example("plastic");
  scene.bodies.back().material->plastic_yield.reset();
  const Simulation springs_back = run(scene);
  EXPECT_GT(sag(yields), 0.02);
  EXPECT_LT(sag(springs_back), 0.003) << "its own weight";
}

TEST(Examples, PlatesPressABallWithTheSameForce) {
  const Simulation simulation = run(example("press"));
  EXPECT_TRUE(simulation.at_rest());
  const double force = force_on(simulation, "upper").z;
  EXPECT_NEAR(-force_on(simulation, "lower").z, force, 0.005 * force);
  // Hertz, a lower bound (tests/sim/contact_mechanics_test.cpp): each plate comes 14 mm nearer to the centre.
  const double hertz = 4.0 / 3.0 * 1e5 / (1.0 - 0.3 * 0.3) * std::sqrt(0.05) * std::pow(0.014, 1.5);
  EXPECT_GT(force, hertz);
  EXPECT_LT(force, 1.6 * hertz);
}

TEST(Examples, OfABarOfTwoMaterialsTheSoftHalfHangsDownMore) {
  const Simulation simulation = run(example("regions"));
  EXPECT_TRUE(simulation.at_rest());
  const double middle = height_at(simulation, "bar", 0.0);
  const double soft = middle - height_at(simulation, "bar", -0.12);
  const double stiff = middle - height_at(simulation, "bar", 0.12);
  EXPECT_GT(stiff, 0.0);
  EXPECT_GT(soft, 3.0 * stiff);
  Scene scene = example("regions");
  scene.bodies.back().regions.clear();
  const Simulation one_material = run(scene);
  EXPECT_NEAR(height_at(one_material, "bar", -0.12), height_at(one_material, "bar", 0.12), 0.001);
}

TEST(Examples, ATowerOfTenBlocksStands) {
  const Simulation simulation = run(example("tower"));
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_TRUE(simulation.metrics().solver_converged);
  const double weight = 10.0 * weight_of(simulation, "block 0");
  EXPECT_NEAR(-force_on(simulation, "plate").z, weight, 0.001 * weight);
  EXPECT_NEAR(heights(simulation, "block 9").highest, 0.4, 0.003);
}

TEST(Examples, BlocksOfTwoStiffnessesHaveEqualForcesAndDeformByTheirStiffness) {
  const Simulation simulation = run(example("two-stiffnesses"));
  EXPECT_TRUE(simulation.at_rest());
  const double force = force_on(simulation, "upper").z;
  EXPECT_NEAR(-force_on(simulation, "lower").z, force, 0.005 * force);
  const double ratio =
      (0.04 - heights(simulation, "soft").extent()) / (0.04 - heights(simulation, "stiff").extent());
  EXPECT_NEAR(ratio, 4.0, 0.4) << "the rim of the interface bears less, the more the coarser the mesh";
}

}  // namespace
}  // namespace palpate::test

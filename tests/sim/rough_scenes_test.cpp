// Small scenes of shared/data/rough that broke once: a box fell through a box, bars through bars, a sheet
// through a plate. Oracles: where bodies rest by hand, and exact tests of their surfaces against each other.
#include <array>
#include <vector>

#include "geometry/predicates.hpp"
#include "sim/examples.hpp"
#include "sim/unseen_passes.hpp"
#include "support/real_data.hpp"

namespace palpate::test {
namespace {

class RoughScenes : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(folder_)) GTEST_SKIP() << "no data in " << folder_;
  }
  /// With the default preconditioner: a scene names one that is gone.
  [[nodiscard]] Scene scene(const std::string& name) const {
    return read_scene(folder_ / (name + ".json"), std::array{std::string("solver.preconditioner=auto")});
  }

 private:
  std::filesystem::path folder_ = real_data_folder() / "rough";
};

/// A bar that was put on another one along y lies on it: no point of either is inside the other, and an edge
/// is.
void expect_on_the_lower_bar(const Simulation& simulation) {
  EXPECT_EQ(simulation.detector().contacts().size(), 0U);
  EXPECT_GT(simulation.detector().edge_contacts().size(), 0U);
  // The lower bar ends at 0.06. The ends of the upper one hang down.
  EXPECT_LT(centre(simulation, "upper").z, 0.0701);
  EXPECT_GT(centre(simulation, "upper").z, 0.068);
}

TEST_F(RoughScenes, ABoxOfOneCellRestsOnAnother) {
  const Simulation simulation = run(scene("boxes"));
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_NEAR(centre(simulation, "high").z, 0.1, 0.001) << "within 1 % of the cell";
}

TEST_F(RoughScenes, TwoSoftBoxesOfOneCellRestOnEachOther) {
  const Simulation simulation = run(scene("boxes_soft"));
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_NEAR(centre(simulation, "low").z, 0.05, 0.001);
  EXPECT_NEAR(centre(simulation, "high").z, 0.15, 0.001);
}

TEST_F(RoughScenes, ATowerOfTenBoxesStands) {
  const Simulation simulation = run(scene("tower10"));
  EXPECT_TRUE(simulation.at_rest());
  for (int level = 0; level < 10; ++level) {
    const Vec3 here = centre(simulation, "b" + std::to_string(level));
    EXPECT_NEAR(here.z, 0.05 + 0.1 * level, 0.001) << level;
    EXPECT_LT(std::hypot(here.x, here.y), 0.001) << level;
  }
}

TEST_F(RoughScenes, CrossedBarsOfOneAndThreeCellsRest) {
  for (const char* name : {"crossed-bars-1", "crossed-bars-3"}) {
    SCOPED_TRACE(name);
    const Simulation simulation = run(scene(name));
    EXPECT_TRUE(simulation.at_rest());
    expect_on_the_lower_bar(simulation);
  }
}

/// Without friction it turns slowly (docs/edges.md, Limits).
TEST_F(RoughScenes, CrossedBarsOfFiveCellsStayOnEachOther) {
  const Simulation simulation = run(scene("crossed-bars-5"));
  EXPECT_LT(simulation.metrics().fastest_body, 0.005);
  EXPECT_LT(centre(simulation, "upper").z, 0.0701);
  EXPECT_GT(centre(simulation, "upper").z, 0.066) << "its ends hang down";
}

/// Number of edges of one body's surface that cross the surface of the other.
int crossings(const Simulation& simulation, Index edges, Index triangles) {
  const Bodies& bodies = simulation.bodies();
  const auto x = simulation.positions();
  const auto sides = [&](Index body) { return at(bodies.bodies(), body).triangles; };
  int found = 0;
  for (Index e = sides(edges).begin; e < sides(edges).end; ++e) {
    for (std::size_t c = 0; c < 3; ++c) {
      const Index p = at(bodies.triangles(), e)[c];
      const Index q = at(bodies.triangles(), e)[(c + 1) % 3];
      if (p > q) continue;
      for (Index t = sides(triangles).begin; t < sides(triangles).end; ++t) {
        const Triangle& corners = at(bodies.triangles(), t);
        found += segment_meets_triangle(at(x, p), at(x, q), at(x, corners[0]), at(x, corners[1]),
                                        at(x, corners[2]))
                     ? 1
                     : 0;
      }
    }
  }
  return found;
}

/// The upper bar is put beside the middle of the lower one, so it tips over its edge. It turns about it, and
/// never goes deeper into it than a twentieth of the bars' side.
TEST_F(RoughScenes, ABarThatIsNotInBalanceTipsAndDoesNotSink) {
  const Scene bars = scene("crossed-bars-physics");
  Simulation simulation = simulate(bars);
  int steps_in_touch = 0;
  while (simulation.metrics().time < bars.duration - 1e-9) {
    simulation.step();
    EXPECT_LT(simulation.metrics().deepest, 0.001) << simulation.metrics().time;
    const bool cross = crossings(simulation, 0, 1) + crossings(simulation, 1, 0) > 0;
    steps_in_touch += cross ? 1 : 0;
    const bool contact =
        simulation.detector().contacts().size() + simulation.detector().edge_contacts().size() > 0;
    EXPECT_TRUE(contact || !cross) << "surfaces that cross have a contact, " << simulation.metrics().time;
  }
  EXPECT_GT(steps_in_touch, 10);
}

TEST_F(RoughScenes, ASheetDoesNotPassAPlate) {
  const Scene shot = scene("sheet");
  const Simulation simulation = run(shot);
  const Range points = points_of(simulation, "sheet");
  for (Index p = points.begin; p < points.end; ++p) EXPECT_GT(at(simulation.positions(), p).z, 0.0) << p;
}

/// A ball of 1 TPa in steps of 50 ms. Implicit Euler falls by g h^2 n (n + 1) / 2 in n steps.
TEST_F(RoughScenes, AnAlmostRigidBallFallsAsAPoint) {
  const Scene fall = scene("fall");
  const double h = fall.settings.time_step;
  Simulation simulation = simulate(fall);
  const std::vector<Vec3> start(simulation.positions().begin(), simulation.positions().end());
  const int steps = static_cast<int>(std::lround(fall.duration / h));
  for (int step = 0; step < steps; ++step) EXPECT_TRUE(simulation.step().solver_converged) << step;
  const double fallen = 9.81 * h * h * 0.5 * steps * (steps + 1);
  for (std::size_t p = 0; p < start.size(); ++p)
    EXPECT_LT(length(simulation.positions()[p] - start[p] - Vec3{0, 0, -fallen}), 1e-6 * fallen) << p;
}

/// Without continuous detection it does, and the metrics tell that it could.
TEST_F(RoughScenes, ASheetThatMayPassAPlateUnseenIsCounted) {
  Scene shot = scene("sheet");
  shot.settings.detection.continuous = ContinuousDetection::off;
  Simulation simulation = simulate(shot);
  int could = 0;
  while (simulation.metrics().time < shot.duration - 1e-9) {
    if (simulation.step().pairs_that_could_pass == 0) continue;
    ++could;
    EXPECT_NEAR(simulation.metrics().thinnest, 0.002, 1e-9);
  }
  EXPECT_GE(could, 1);
  EXPECT_LT(could, 10) << "only those in which they meet";
}

/// With points alone, the upper bar falls through the lower one; the metrics tell that nobody saw it.
TEST_F(RoughScenes, ABarThatFallsThroughAnotherForWantOfEdgesIsCounted) {
  for (const auto continuous : {ContinuousDetection::off, ContinuousDetection::limited}) {
    Scene bars = scene("crossed-bars-1");
    bars.settings.detection.edge_contacts = false;
    bars.settings.detection.continuous = continuous;
    Simulation simulation = simulate(bars);
    int could = 0;
    while (simulation.metrics().time < bars.duration - 1e-9) {
      could += may_have_passed(simulation.step(), continuous) ? 1 : 0;
      EXPECT_EQ(simulation.metrics().passes, 0);
    }
    EXPECT_LT(centre(simulation, "upper").z, 0.0) << "it has fallen through";
    EXPECT_GE(could, 1);
    EXPECT_LT(could, 30) << "it falls on for 200 steps";
  }
}

}  // namespace
}  // namespace palpate::test

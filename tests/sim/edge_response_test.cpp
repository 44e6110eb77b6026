// Oracles: where bodies rest by hand; Newton's third law; a run that was not interrupted.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>
#include <vector>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/exact_runs.hpp"
#include "sim/examples.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

TetMesh moved(TetMesh mesh, const Vec3& by) {
  for (Vec3& p : mesh.points) p += by;
  return mesh;
}

Vec3 centre(const Simulation& simulation, Index body) {
  return simulation.center_of_mass(body);
}

/// A bar of 0.2 x 0.02 x 0.02 along x or y.
TetMesh bar(int cells, bool along_x, const Vec3& at_centre) {
  const std::array<int, 3> n = along_x ? std::array{cells, 1, 1} : std::array{1, cells, 1};
  const Vec3 half = along_x ? Vec3{0.1, 0.01, 0.01} : Vec3{0.01, 0.1, 0.01};
  return test::box_mesh(n, at_centre - half, at_centre + half);
}

Simulation crossed_bars(int cells, double gap) {
  Model model;
  model.bodies.add("lower", bar(cells, true, {}));
  model.bodies.add("upper", bar(cells, false, {0.003, 0.001, 0.02 + gap}));
  model.materials.assign(2, Material{.young_modulus = 1e7});
  model.obstacles = {1, 0};
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  settings.time_step = 0.005;
  settings.response.friction = 0.5;
  return {std::move(model), settings, 2};
}

TEST(EdgeContactResponse, BarsThatCrossEdgeOnEdgeRest) {
  for (const int cells : {1, 3, 5}) {
    SCOPED_TRACE(cells);
    Simulation simulation = crossed_bars(cells, 0.01);
    for (int step = 0; step < 200; ++step) simulation.step();
    EXPECT_EQ(simulation.detector().contacts().size(), 0U) << "no point is in the other bar";
    EXPECT_GT(simulation.detector().edge_contacts().size(), 3U);
    EXPECT_EQ(simulation.metrics().deepest, std::ranges::max(simulation.detector().edge_contacts().depth));
    EXPECT_NEAR(centre(simulation, 1).z, 0.02, 0.0005);
    EXPECT_LT(simulation.metrics().fastest_body, 1e-3);
    const double weight = test::g * simulation.masses()[1];
    EXPECT_NEAR(simulation.contact_forces()[1].z, weight, 1e-3 * weight);
  }
}

TEST(EdgeContactResponse, WithoutEdgesABarFallsThrough) {
  Simulation simulation = crossed_bars(1, 0.01);
  SimulationSettings settings = simulation.settings();
  settings.detection.edge_contacts = false;
  simulation.change(settings);
  for (int step = 0; step < 60; ++step) simulation.step();
  EXPECT_LT(centre(simulation, 1).z, -0.1) << "the paper's contacts, on which the test above would fail";
}

/// Its middle is not above the lower bar.
TEST(EdgeContactResponse, ABarThatIsNotSupportedTipsOver) {
  Model model;
  model.bodies.add("lower", bar(8, true, {}));
  model.bodies.add("upper", bar(8, false, {0.0125, 0.015, 0.022}));
  model.materials.assign(2, Material{.young_modulus = 1e7});
  model.obstacles = {1, 0};
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  settings.time_step = 0.005;
  Simulation simulation(std::move(model), settings, 2);
  for (int step = 0; step < 30; ++step) simulation.step();
  EXPECT_GT(centre(simulation, 1).z, 0.015) << "it does not fall through";
  for (int step = 0; step < 150; ++step) simulation.step();
  EXPECT_LT(centre(simulation, 1).z, -0.1);
}

/// The middle of the ridge comes into contact as the bar bends over it, while the edges beside it are deep.
TEST(EdgeContactResponse, ABarThatBendsOverARidgeDoesNotTremble) {
  Simulation simulation = test::simulate(test::example("attached"));
  const Index bar = test::body_named(simulation, "bar");
  const Bodies& bodies = simulation.bodies();
  test::run_to(simulation, 0.35);
  // The point of the bar that is nearest to the ridge, which is at x = 0.07 along y.
  Index lowest = -1;
  double nearest = 1.0;
  const Range points = at(bodies.bodies(), bar).points;
  for (Index p = points.begin; p < points.end; ++p) {
    const double distance = length(at(simulation.positions(), p) - Vec3{0.07, 0.0, std::sqrt(2e-4)});
    if (distance < nearest) lowest = p;
    nearest = std::min(nearest, distance);
  }
  EXPECT_LT(nearest, 1.5e-3);
  std::vector<double> heights;
  for (int step = 0; step < 18; ++step) {  // then it begins to slip
    heights.push_back(at(simulation.positions(), lowest).z);
    simulation.step();
  }
  for (std::size_t i = 2; i < heights.size(); ++i) {
    EXPECT_LT(std::abs(heights[i] - 2.0 * heights[i - 1] + heights[i - 2]), 2e-5) << "step " << i;
  }
}

struct Alignment {
  int cells;
  double offset;     ///< m
  double stiffness;  ///< Pa
  double time_step;  ///< s
};

/// A box of 0.1 on a fixed one.
Simulation box_on_box(const Alignment& a) {
  const TetMesh box = test::box_mesh({a.cells, a.cells, a.cells}, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
  Model model;
  model.bodies.add("low", box);
  model.bodies.add("high", moved(box, {a.offset, 0.5 * a.offset, 0.1005}));
  model.materials.assign(2, Material{.young_modulus = a.stiffness});
  model.obstacles = {1, 0};
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  settings.time_step = a.time_step;
  settings.response.friction = 0.5;
  return {std::move(model), settings, 2};
}

/// Mean height of the points that are at `height` at rest.
double mean_height(const Simulation& simulation, Index body, double height) {
  const Range points = at(simulation.bodies().bodies(), body).points;
  double sum = 0.0;
  int count = 0;
  for (Index p = points.begin; p < points.end; ++p) {
    if (std::abs(at(simulation.bodies().points_rest(), p).z - height) > 1e-4) continue;
    sum += at(simulation.positions(), p).z;
    ++count;
  }
  return sum / count;
}

/// Runs four seconds.
Simulation settled(Model model) {
  SimulationSettings settings;
  settings.time_step = 0.02;
  settings.response.friction = 0.5;
  Simulation simulation(std::move(model), settings, 2);
  for (int step = 0; step < 200; ++step) simulation.step();
  return simulation;
}

void hold_lowest(Model& model, double height) {
  for (const Vec3& p : model.bodies.points_rest()) model.fixed_points.push_back(p.z < height ? 1 : 0);
}

struct Pair {
  double stiffness;
  int cells;
  int below;  ///< cells of an obstacle, along each side
};

/// Oracle: the two boxes as one body, or a box that is fixed at its bottom.
TEST(Aligned, SoftBoxesRestAsIfTheyWereOneBody) {
  const auto box = [](int cells, double low, double high, double offset) {
    const int layers = static_cast<int>(std::lround(cells * (high - low) / 0.1));
    return test::box_mesh({cells, cells, layers}, {-0.05 + offset, -0.05, low}, {0.05 + offset, 0.05, high});
  };
  constexpr double above = 1e-6;
  for (const auto& [stiffness, cells, below] : {Pair{3e4, 2, 2},
                                                {3e4, 4, 4},
                                                {3e4, 8, 8},
                                                {1e5, 1, 1},
                                                {1e5, 2, 2},
                                                {1e5, 4, 4},
                                                {1e6, 1, 1},
                                                {1e6, 4, 4},
                                                {1e6, 8, 8},
                                                {3e4, 4, 1},
                                                {3e4, 4, 2},
                                                {3e4, 8, 2},
                                                {1e5, 8, 1}}) {
    const Material material{.young_modulus = stiffness};
    for (const bool fixed : {false, true}) {
      if (!fixed && below != cells) continue;
      Model joined;
      joined.bodies.add("both", box(cells, fixed ? 0.0 : -0.1, 0.1, 0.0));
      joined.materials.assign(1, material);
      hold_lowest(joined, fixed ? 1e-4 : -0.0999);
      const double expected = mean_height(settled(std::move(joined)), 0, 0.1);
      for (const double offset : {0.0, 1e-3}) {
        SCOPED_TRACE(std::to_string(cells) + " cells, E " + std::to_string(stiffness) + ", offset " +
                     std::to_string(offset) +
                     (fixed ? ", on an obstacle of " + std::to_string(below) + " cells" : ""));
        Model model;
        model.bodies.add("low", box(below, -0.1, 0.0, 0.0));
        model.bodies.add("high", box(cells, above, 0.1 + above, offset));
        model.materials.assign(2, material);
        if (fixed) {
          model.obstacles = {1, 0};
        } else {
          hold_lowest(model, -0.0999);
        }
        const Simulation simulation = settled(std::move(model));
        EXPECT_NEAR(mean_height(simulation, 1, 0.1 + above), expected, 0.01 * 0.1 / cells);
        EXPECT_LT(simulation.metrics().fastest_body, 2e-3);
      }
    }
  }
}

TEST(Aligned, ATowerOfTenBoxesStands) {
  const TetMesh box = test::box_mesh({2, 2, 2}, {-0.05, -0.05, -0.05}, {0.05, 0.05, 0.05});
  Model model;
  model.bodies.add("floor", test::box_mesh({4, 4, 1}, {-0.29, -0.29, -0.05}, {0.31, 0.31, 0.0}));
  for (int i = 0; i < 10; ++i) model.bodies.add("box", moved(box, {0.0, 0.0, 0.0501 + 0.1001 * i}));
  model.materials.assign(11, Material{.young_modulus = 1e8});
  model.obstacles.assign(11, 0);
  model.obstacles[0] = 1;
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  settings.response.friction = 0.5;
  Simulation simulation(std::move(model), settings, 2);
  for (int step = 0; step < 150; ++step) simulation.step();
  for (Index b = 1; b <= 10; ++b) {
    EXPECT_NEAR(centre(simulation, b).z, 0.1 * b - 0.05, 0.0005) << b;
    EXPECT_NEAR(centre(simulation, b).x, 0.0, 0.0005) << b;
  }
  EXPECT_LT(simulation.metrics().fastest_body, 1e-3);
}

/// Two slabs side by side are one floor: a block slides over their seam without friction. Points close to it
/// still see both bodies, so some speed is lost (docs/architecture.md).
TEST(Aligned, TheFlushSeamOfTwoObstaclesStopsNoBlock) {
  for (const double stiffness : {1e4, 1e6, 2e7}) {
    for (const int cells : {1, 2, 4}) {
      for (const int of_floor : {1, 4}) {
        SCOPED_TRACE(std::to_string(cells) + " cells on " + std::to_string(of_floor) + ", E " +
                     std::to_string(stiffness));
        Model model;
        model.bodies.add("left", test::box_mesh({of_floor, of_floor, 1}, {-0.4, -0.2, -0.05}, {0, 0.2, 0}));
        model.bodies.add("right", test::box_mesh({of_floor, of_floor, 1}, {0, -0.2, -0.05}, {0.4, 0.2, 0}));
        model.bodies.add(
            "block", test::box_mesh({cells, cells, cells}, {-0.11, -0.019, 0.0001}, {-0.05, 0.041, 0.0601}));
        model.materials.assign(3, Material{.young_modulus = stiffness});
        model.obstacles = {1, 1, 0};
        for (const Vec3& p : model.bodies.points_rest())
          model.velocities.push_back(p.z > 0.0 ? Vec3{0.5, 0.0, 0.0} : Vec3{});
        Simulation simulation(std::move(model), {}, 1);
        for (int step = 0; step < 40; ++step) simulation.step();
        EXPECT_GT(centre(simulation, 2).x, 0.05) << "it is beyond the seam";
        EXPECT_GT(test::mean_of_body(simulation.bodies(), 2, simulation.velocities()).x,
                  of_floor == 4 ? 0.47 : 0.42);
      }
    }
  }
}

TEST(EdgeContactResponse, ForcesAndTorquesAddUpToZero) {
  Model model;
  model.bodies.add("lower", bar(1, true, {}));
  model.bodies.add("upper", bar(1, false, {0.003, 0.02, 0.0195}));
  model.materials.assign(2, Material{.young_modulus = 1e6});
  SimulationSettings settings;
  settings.detection.edge_contacts = true;
  settings.response.friction = 0.5;
  Simulation simulation(std::move(model), settings, 1);
  simulation.step();
  const ContactForces forces = simulation.acting_contacts();
  ASSERT_GT(forces.size(), 0U);
  EXPECT_TRUE(std::ranges::all_of(forces.edge, [](Index edge) { return edge >= 0; }));
  const Vec3 on_upper = simulation.contact_forces()[1];
  EXPECT_GT(on_upper.z, 0.01);
  EXPECT_LT(length(on_upper + simulation.contact_forces()[0]), 1e-13 * length(on_upper));
  const Wrench upper = simulation.contact_wrench(1, {});
  const Wrench lower = simulation.contact_wrench(0, {});
  EXPECT_LT(length(upper.torque + lower.torque), 1e-13 * length(upper.torque));
  Vec3 sum;
  for (std::size_t c = 0; c < forces.size(); ++c) sum += (forces.body[c] == 0 ? 1.0 : -1.0) * forces.force(c);
  EXPECT_LT(length(sum - on_upper), 1e-13 * length(on_upper)) << "listed with their forces";
}

TEST(EdgeContactResponse, ARunGoesOnFromASavedStateToTheBit) {
  for (const bool bars : {true, false}) {
    const auto make = [&] { return bars ? crossed_bars(1, 0.001) : box_on_box({1, 1e-3, 1e6, 0.005}); };
    Simulation whole = make();
    for (int step = 0; step < 12; ++step) whole.step();
    const std::vector<std::byte> saved = whole.save();
    for (int step = 0; step < 30; ++step) whole.step();
    Simulation resumed = make();
    resumed.restore(saved);
    for (int step = 0; step < 30; ++step) resumed.step();
    EXPECT_EQ(resumed.state_hash(), whole.state_hash());
  }
}

/// A box that slides off over the rim of another one: its edges begin and end to act beside rims.
TEST(EdgeContactResponse, EachStateOfASlidingBoxCanBeRestored) {
  const TetMesh box = test::box_mesh({6, 6, 3}, {-0.05, -0.05, -0.025}, {0.05, 0.05, 0.025});
  const auto make = [&](double speed) {
    Model model;
    model.bodies.add("low", box);
    model.bodies.add("high", moved(box, {0.0, 0.0, 0.04999}));
    model.materials.assign(2, Material{.young_modulus = 3e4});
    for (const Vec3& p : model.bodies.points_rest()) {
      model.fixed_points.push_back(p.z < -0.0249 ? 1 : 0);
      model.velocities.push_back(p.z > 0.0249 ? Vec3{speed, 0.3 * speed, 0.0} : Vec3{});
    }
    SimulationSettings settings;
    settings.time_step = 0.005;
    settings.response.friction = 0.05;
    return Simulation(std::move(model), settings, 1);
  };
  std::size_t most = 0;
  for (const double speed : {0.0, 0.3}) {
    Simulation whole = make(speed);
    Simulation resumed = make(speed);
    for (int step = 0; step < 60; ++step) {
      resumed.restore(whole.save());
      whole.step();
      resumed.step();
      ASSERT_EQ(resumed.state_hash(), whole.state_hash()) << "step " << step;
      const ContactForces& forces = whole.acting_contacts();
      most = std::max(most, static_cast<std::size_t>(
                                std::ranges::count_if(forces.edge, [](Index edge) { return edge >= 0; })));
    }
  }
  EXPECT_GT(most, 20U) << "edges act";
}

}  // namespace
}  // namespace palpate

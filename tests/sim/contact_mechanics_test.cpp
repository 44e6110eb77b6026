// Contact of soft bodies against contact mechanics: Hertz, springs in series, stable stacks.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

Vec3 centre(const Simulation& simulation, Index body) {
  return test::mean_of_body(simulation.bodies(), body, simulation.positions());
}

Vec3 mean_velocity(const Simulation& simulation, Index body) {
  return test::mean_of_body(simulation.bodies(), body, simulation.velocities());
}

/// Two rigid plates (bodies 0 and 1) that approach each other along z by `closing` within `time`; the caller
/// adds bodies between them.
Model press(double half_gap, double closing, double time) {
  Model model;
  model.bodies.add("lower",
                   test::box_mesh({2, 2, 1}, {-0.06, -0.06, -half_gap - 0.02}, {0.06, 0.06, -half_gap}));
  model.bodies.add("upper",
                   test::box_mesh({2, 2, 1}, {-0.06, -0.06, half_gap}, {0.06, 0.06, half_gap + 0.02}));
  model.motion_of_point.assign(model.bodies.points_rest().size(), 1);
  for (Index p = 0; p < model.bodies.bodies()[0].points.end; ++p) at(model.motion_of_point, p) = 0;
  for (const double sign : {1.0, -1.0}) {
    model.motions.push_back({{},
                             {{0.0, {}, {1, 0, 0, 0}}, {time, {0, 0, sign * 0.5 * closing}, {1, 0, 0, 0}}},
                             Interpolation::smooth});
  }
  model.materials.resize(2);
  model.obstacles = {1, 1};
  return model;
}

void add_soft(Model& model, const std::string& name, TetMesh mesh, const Material& material) {
  model.bodies.add(name, std::move(mesh));
  model.materials.push_back(material);
  model.obstacles.push_back(0);
  model.motion_of_point.resize(model.bodies.points_rest().size(), -1);
}

constexpr double ball_radius = 0.05;
const Material ball_material{
    .young_modulus = 1e5, .poisson_ratio = 0.3, .mass_damping = 5.0, .stiffness_damping = 0.01};

/// Force on a ball between two plates that each come nearer to its centre by `approach`.
double pressing_force(int layers, double approach) {
  Model model = press(ball_radius, 2.0 * approach, 0.5);
  add_soft(model, "ball", test::ball_mesh(layers, {0, 0, 0}, ball_radius), ball_material);
  SimulationSettings settings;
  settings.gravity = {};
  settings.rest.speed = 1e-5;
  settings.solver.tolerance = 1e-6;
  settings.solver.max_iterations = 1000;
  settings.response.stiffness = 40.0 * ball_material.young_modulus * ball_radius / layers;
  Simulation simulation(std::move(model), settings, 2);
  while (!simulation.at_rest() && simulation.metrics().step < 400) simulation.step();
  EXPECT_TRUE(simulation.at_rest());
  const double force = -simulation.contact_forces()[0].z;
  EXPECT_NEAR(simulation.contact_forces()[1].z, force, 0.01 * force) << "both plates feel the same";
  EXPECT_LT(simulation.metrics().deepest, 0.025 * approach) << "the contact springs give next to nothing";
  return force;
}

/// Hertz: F = 4/3 E / (1 - nu^2) sqrt(R) d^(3/2), with the ball as a half-space outside its contact.
double force_by_hertz(double approach) {
  const double nu = ball_material.poisson_ratio;
  return 4.0 / 3.0 * ball_material.young_modulus / (1.0 - nu * nu) * std::sqrt(ball_radius) *
         std::pow(approach, 1.5);
}

/// Tatara, "On compression of rubber elastic sphere over a large range of displacements", J. Eng. Mater.
/// Technol. 113 (1991): the ball is finite, and the other plate's push moves its centre, so that Hertz's own
/// approach is larger by f F / (pi E).
double force_by_tatara(double approach) {
  const double nu = ball_material.poisson_ratio;
  const double radius = ball_radius;
  double force = force_by_hertz(approach);
  for (int i = 0; i < 50; ++i) {
    const double a2 = radius * approach;  // squared contact radius
    const double l2 = a2 + 4.0 * radius * radius;
    const double f = 2.0 * (1.0 + nu) * radius * radius / std::pow(l2, 1.5) + (1.0 - nu * nu) / std::sqrt(l2);
    force = force_by_hertz(approach + f * force / (3.14159265358979 * ball_material.young_modulus));
  }
  return force;
}

TEST(ContactMechanics, ABallBetweenPlatesFollowsHertz) {
  // Hertz is the lower bound, with contacts far smaller than the ball; Tatara's correction is of first order
  // and too large. The mesh has 2, 3 and 4 layers of tets across the radius of the contact.
  constexpr double approach = 0.1 * ball_radius;
  const double coarse = pressing_force(6, approach);
  const double medium = pressing_force(10, approach);
  const double fine = pressing_force(14, approach);
  for (const double force : {coarse, medium, fine}) {
    EXPECT_GT(force, force_by_hertz(approach));
    EXPECT_LT(force, force_by_tatara(approach));
  }
  EXPECT_LT(std::abs(fine - medium), std::abs(medium - coarse)) << "converges";
  EXPECT_LT(std::abs(fine - medium), 0.03 * fine);
  const double exponent = std::log2(fine / pressing_force(14, 0.5 * approach));
  EXPECT_NEAR(exponent, 1.5, 0.05);
}

/// Uniaxial strain: a cube in a rigid cavity resists by E (1 - nu) / ((1 + nu) (1 - 2 nu)) times strain and
/// area, 17 E with nu = 0.49. With contacts as stiff as for compressible tissue, it resisted by half of this.
TEST(ContactMechanics, ConfinedTissueResistsByItsModulus) {
  constexpr double half = 0.02;
  constexpr double strain = 0.01;
  for (const double nu : {0.3, 0.45, 0.49}) {
    Model model = press(half, strain * 2.0 * half, 0.5);
    for (const double sign : {-1.0, 1.0}) {
      const auto [near, far] = std::minmax({sign * half, sign * 2.0 * half});
      add_soft(model, "side", test::box_mesh({2, 2, 2}, {near, -0.04, -0.04}, {far, 0.04, 0.04}), {});
      add_soft(model, "front", test::box_mesh({2, 2, 2}, {-0.04, near, -0.04}, {0.04, far, 0.04}), {});
    }
    std::ranges::fill(model.obstacles, 1);
    const Material tissue{.young_modulus = 5e4, .poisson_ratio = nu, .mass_damping = 20.0};
    add_soft(model, "tissue", test::box_mesh({4, 4, 4}, {-half, -half, -half}, {half, half, half}), tissue);
    SimulationSettings settings;
    settings.gravity = {};
    Simulation simulation(std::move(model), settings, 2);
    while (simulation.metrics().time < 2.0) simulation.step();
    const double modulus = tissue.young_modulus * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
    const double force = modulus * strain * 4.0 * half * half;
    const double felt = simulation.contact_forces()[1].z;
    EXPECT_GT(felt, 0.8 * force) << nu;
    EXPECT_LT(felt, force) << nu << ": the contacts yield, too";
  }
}

TEST(ContactMechanics, TwoPressedBlocksHaveEqualForcesAndDeformByTheirStiffness) {
  // Springs in series, E A / L each. Without friction the blocks would slip sideways, since two blocks that
  // are shifted store less energy. Without Poisson's ratio they do not slide otherwise, so friction adds no
  // force.
  constexpr double side = 0.04;
  constexpr double closing = 0.004;
  const Material soft{
      .young_modulus = 5e4, .poisson_ratio = 0.0, .mass_damping = 5.0, .stiffness_damping = 0.01};
  const Material stiff{
      .young_modulus = 2e5, .poisson_ratio = 0.0, .mass_damping = 5.0, .stiffness_damping = 0.01};
  Model model = press(side, closing, 0.5);
  add_soft(model, "soft", test::box_mesh({8, 8, 8}, {-0.02, -0.02, -side}, {0.02, 0.02, 0}), soft);
  add_soft(model, "stiff", test::box_mesh({7, 7, 7}, {-0.02, -0.02, 0}, {0.02, 0.02, side}), stiff);
  SimulationSettings settings;
  settings.gravity = {};
  settings.rest.speed = 1e-5;
  settings.response.stiffness = 5e5;
  settings.response.friction = 0.1;
  Simulation simulation(std::move(model), settings, 2);
  while (!simulation.at_rest() && simulation.metrics().step < 600) simulation.step();
  ASSERT_TRUE(simulation.at_rest());
  const double force = -simulation.contact_forces()[0].z;
  EXPECT_NEAR(simulation.contact_forces()[1].z, force, 0.01 * force);
  const double expected = closing * side / (1.0 / soft.young_modulus + 1.0 / stiff.young_modulus);
  EXPECT_NEAR(force, expected, 0.04 * expected);
  // The soft block has four fifths of the compression. Rims bulge and carry less, so only points inside them
  // count.
  const auto moves_on = [&](Index body) {
    const Range points = at(simulation.bodies().bodies(), body).points;
    double sum = 0.0;
    int count = 0;
    for (Index p = points.begin; p < points.end; ++p) {
      const Vec3& rest = at(simulation.bodies().points_rest(), p);
      if (rest.z != 0.0 || std::max(std::abs(rest.x), std::abs(rest.y)) > 0.49 * side) continue;
      sum += at(simulation.positions(), p).z;
      ++count;
    }
    return sum / count;
  };
  EXPECT_NEAR(-moves_on(2), 0.8 * closing - 0.5 * closing, 0.01 * closing);
  EXPECT_NEAR(-moves_on(3), 0.8 * closing - 0.5 * closing, 0.01 * closing);
}

/// Acceleration of a block on an inclined plane, over the analytic one. The plane has a point every 41.7 mm,
/// and the block, 80 mm long, slides over them.
double sliding_by_coulomb(double young_modulus, double friction, double time_step,
                          ContinuousDetection continuous) {
  constexpr double angle = 20.0 * 3.14159265358979 / 180.0;
  Model model;
  model.bodies.add("plane", test::box_mesh({48, 4, 1}, {-0.2, -0.07, -0.02}, {1.8, 0.07, 0}));
  model.materials.resize(1);
  model.obstacles = {1};
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  add_soft(model, "block", test::box_mesh({6, 6, 3}, {-0.04, -0.04, 1e-5}, {0.04, 0.04, 0.04001}),
           Material{.young_modulus = young_modulus, .stiffness_damping = 0.005});
  SimulationSettings settings;
  settings.time_step = time_step;
  settings.gravity = {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)};
  settings.response.friction = friction;
  settings.detection.continuous = continuous;
  Simulation simulation(std::move(model), settings, 2);
  const auto velocity_at = [&](double time) {
    while (simulation.metrics().time < time - 1e-9) simulation.step();
    const Range points = simulation.bodies().bodies()[1].points;
    double sum = 0.0;
    for (Index p = points.begin; p < points.end; ++p) sum += at(simulation.velocities(), p).x;
    return sum / points.size();
  };
  const double start = velocity_at(0.2);
  return (velocity_at(1.0) - start) / 0.8 / (9.81 * (std::sin(angle) - friction * std::cos(angle)));
}

TEST(ContactMechanics, ABlockSlidesOverAPlaneOfManyTrianglesAsCoulombSays) {
  for (const auto& [young_modulus, time_step] : {std::pair{2e5, 0.0025},
                                                 {2e5, 0.005},
                                                 {2e5, 0.01},
                                                 {2e5, 0.02},
                                                 {6e6, 0.0025},
                                                 {6e6, 0.005},
                                                 {6e6, 0.01},
                                                 {6e6, 0.02}}) {
    for (const auto continuous : {ContinuousDetection::off, ContinuousDetection::limited}) {
      EXPECT_NEAR(sliding_by_coulomb(young_modulus, 0.3, time_step, continuous), 1.0, 0.01)
          << "E " << young_modulus << ", step " << time_step << ", continuous "
          << continuous_detection_names[static_cast<std::size_t>(continuous)];
    }
  }
}

/// Ten blocks on each other, each up to 8 mm beside the one below, with gaps between them.
class Tower {
 public:
  Tower(double young_modulus, double time_step, double gap)
      : simulation_(model(young_modulus, gap), settings(time_step), 2) {}
  Simulation& simulation() { return simulation_; }
  void run_to(double time) {
    while (simulation_.metrics().time < time - 1e-9) {
      simulation_.step();
      deepest_ = std::max(deepest_, simulation_.metrics().deepest);
    }
  }
  [[nodiscard]] Vec3 top() const { return centre(simulation_, 10); }
  [[nodiscard]] double deepest() const { return deepest_; }
  static constexpr double weight = 10 * 9.81 * 0.064;

 private:
  static Model model(double young_modulus, double gap) {
    Model model;
    model.bodies.add("plate", test::box_mesh({4, 4, 1}, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0}));
    for (int i = 0; i < 10; ++i) {
      const double z = i * (0.04 + gap) + gap;
      const double x = 0.002 * ((i * 7) % 5 - 2) - 0.02;
      const double y = 0.0015 * ((i * 3) % 4 - 1.5) - 0.02;
      model.bodies.add("block " + std::to_string(i),
                       test::box_mesh({3, 3, 3}, {x, y, z}, {x + 0.04, y + 0.04, z + 0.04}));
    }
    model.materials.assign(11, Material{.young_modulus = young_modulus, .stiffness_damping = 1e-3});
    model.obstacles.assign(11, 0);
    model.obstacles[0] = 1;
    return model;
  }
  static SimulationSettings settings(double time_step) {
    SimulationSettings settings;
    settings.time_step = time_step;
    settings.response.friction = 0.5;
    settings.solver.max_iterations = 2000;  // the tower needs many iterations
    return settings;
  }
  Simulation simulation_;
  double deepest_ = 0.0;
};

TEST(ContactMechanics, AStackOfTenBlocksStandsStillForTenSecondsInStepsOf10Milliseconds) {
  Tower tower(2e7, 0.01, 1e-4);
  tower.run_to(3.0);  // falls 0.1 mm a block and comes to rest
  const Vec3 before = tower.top();
  for (int i = 0; i < 1000; ++i) {
    tower.simulation().step();
    ASSERT_TRUE(tower.simulation().at_rest()) << "step " << tower.simulation().metrics().step;
  }
  EXPECT_LT(length(tower.top() - before), 1e-5);
  EXPECT_NEAR(-tower.simulation().contact_forces()[0].z, Tower::weight, 2e-5 * Tower::weight);
}

TEST(ContactMechanics, APileFallsTogetherAndStands) {
  // Within a step of 20 ms blocks fall further than the gaps between them: each meets the one below within
  // one step. Without speculative contacts they would sink into each other by centimetres.
  Tower tower(2e6, 0.02, 1e-3);
  tower.run_to(3.0);
  EXPECT_LT(tower.deepest(), 0.004) << "what a block falls in one step, 9.81 (20 ms)^2";
  EXPECT_NEAR(tower.top().z, 9.5 * 0.04, 0.001);
  EXPECT_LT(std::hypot(tower.top().x - 0.002 * (63 % 5 - 2), tower.top().y - 0.0015 * (27 % 4 - 1.5)), 0.002);
  EXPECT_NEAR(-tower.simulation().contact_forces()[0].z, Tower::weight, 1e-3 * Tower::weight);
}

TEST(ContactMechanics, FrictionIsWithinItsBoundInTheStepInWhichABlockLands) {
  // It slides at 1 m/s and touches within the step: friction is at most mu times the normal impulse.
  for (const double friction : {0.05, 0.3}) {
    Model model;
    model.bodies.add("plate", test::box_mesh({4, 4, 1}, {-0.3, -0.3, -0.02}, {0.3, 0.3, 0}));
    model.bodies.add("block", test::box_mesh({3, 3, 2}, {-0.13, -0.03, 1e-5}, {-0.07, 0.03, 0.02001}));
    model.materials.assign(2, Material{.young_modulus = 2e7, .stiffness_damping = 0.005});
    model.obstacles = {1, 0};
    model.velocities.assign(model.bodies.points_rest().size(), {1, 0, 0});
    SimulationSettings settings;
    settings.time_step = 0.01;
    settings.response.friction = friction;
    Simulation simulation(std::move(model), settings, 1);
    for (int step = 0; step < 3; ++step) {
      simulation.step();
      const Vec3 force = simulation.contact_forces()[1];
      EXPECT_GT(force.z, 0.0);
      EXPECT_NEAR(-force.x, friction * force.z, 0.02 * friction * force.z) << "step " << step;
    }
  }
}

TEST(ContactMechanics, ABlockThatLandsStopsWhereItTouches) {
  // At 1 m/s it would be 5 mm deep after the step in which it meets the plate.
  Model model;
  model.bodies.add("plate", test::box_mesh({2, 2, 1}, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0}));
  model.bodies.add("block", test::box_mesh({3, 3, 3}, {-0.02, -0.02, 0.005}, {0.02, 0.02, 0.045}));
  model.materials.assign(2, Material{.young_modulus = 1e6, .stiffness_damping = 1e-3});
  model.obstacles = {1, 0};
  model.velocities.assign(model.bodies.points_rest().size(), {0, 0, -1});
  SimulationSettings settings;
  settings.gravity = {};
  settings.time_step = 0.01;
  Simulation simulation(std::move(model), settings, 1);
  const double momentum = simulation.masses()[1];
  simulation.step();
  EXPECT_GT(simulation.metrics().detections, 1);
  EXPECT_LT(simulation.metrics().deepest, 5e-4);
  const double pushed = -simulation.contact_forces()[0].z * settings.time_step;
  EXPECT_NEAR(mean_velocity(simulation, 1).z, pushed / momentum - 1.0, 0.01)
      << "the impulse is what stopped it";
  EXPECT_GT(pushed, 0.4 * momentum) << "half of the step is left to go to the plate";
  for (int i = 0; i < 100; ++i) simulation.step();
  EXPECT_GT(test::mean_of_body(simulation.bodies(), 1, simulation.positions()).z, 0.0199);
}

}  // namespace
}  // namespace palpate

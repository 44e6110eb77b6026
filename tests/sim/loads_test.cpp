// Loads on points and surfaces, and driving a simulation between steps. Oracles: Newton, Hooke, Pascal.
#include "sim/loads.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <ranges>
#include <string>

#include <palpate/error.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/mean.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// A block of 0.1 m alone.
Model block(const Material& material = {
                .young_modulus = 1e5, .poisson_ratio = 0.3, .mass_damping = 5.0, .stiffness_damping = 5e-3}) {
  Model model;
  model.bodies.add("block", test::box_mesh({4, 4, 4}, {0, 0, 0}, {0.1, 0.1, 0.1}));
  model.materials = {material};
  return model;
}

SimulationSettings weightless() {
  SimulationSettings settings;
  settings.gravity = {};
  settings.solver.tolerance = 1e-10;
  settings.solver.max_iterations = 5000;
  return settings;
}

/// Surface triangles all of whose corners fulfil `where` at rest.
template <class Where>
std::vector<Index> faces(const Bodies& bodies, Where&& where) {
  std::vector<Index> found;
  for (std::size_t t = 0; t < bodies.triangles().size(); ++t) {
    bool all = true;
    for (const Index p : bodies.triangles()[t]) all = all && where(at(bodies.points_rest(), p));
    if (all) found.push_back(static_cast<Index>(t));
  }
  return found;
}

std::vector<Index> all_faces(const Bodies& bodies) {
  return faces(bodies, [](const Vec3&) { return true; });
}

template <class Action>
std::string error_of(Action&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Pascal: a pressure on the whole surface changes the volume by p / K, has no net force or torque, and is
/// the stress inside.
TEST(PressureLoad, AllAroundIsThePressureInside) {
  for (const MaterialModel law :
       {MaterialModel::corotational, MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    Material material = block().materials[0];
    material.model = law;
    Model model = block(material);
    model.surface_loads.push_back({.triangles = all_faces(model.bodies), .pressure = 200.0});
    Simulation simulation(std::move(model), weightless(), 2);
    for (int step = 0; step < 300; ++step) simulation.step();
    const TissueState tissue = simulation.tissue();
    const double bulk_modulus = 1e5 / (3.0 * (1.0 - 2.0 * 0.3));
    const double change = 200.0 / bulk_modulus;
    for (std::size_t t = 0; t < tissue.size(); ++t) {
      ASSERT_NEAR(tissue.pressure[t], 200.0, 0.02);
      ASSERT_NEAR(tissue.von_mises[t], 0.0, 0.02);
      ASSERT_NEAR(tissue.volume_ratio[t], 1.0 - change, 2e-5);
    }
    EXPECT_LT(length(simulation.center_of_mass(0) - Vec3{0.05, 0.05, 0.05}), 1e-6);
    // Hooke: the energy of the tissue, without that of the pressure.
    const double volume = 1e-3;
    EXPECT_NEAR(simulation.metrics().elastic_energy / (0.5 * 200.0 * change * volume), 1.0, 0.01);
  }
}

/// The pressure on a rotated body acts along the rotated normal.
TEST(PressureLoad, FollowsTheSurface) {
  Model model = block();
  const std::vector<Index> top = faces(model.bodies, [](const Vec3& p) { return p.z > 0.0999; });
  model.motions.push_back({{0.05, 0.05, 0.05}, {{0.0, {}, {1, 0, 0, 0}}}, Interpolation::linear});
  model.motion_of_point.assign(model.bodies.points_rest().size(), 0);
  model.surface_loads.push_back({.triangles = top, .pressure = 300.0, .traction = {10.0, 0.0, 0.0}});
  Simulation simulation(std::move(model), weightless(), 1);
  simulation.record_reactions(true);
  simulation.step();
  const double area = 0.01;
  EXPECT_LT(length(simulation.reaction_of_body(0, {}).force - Vec3{-10.0 * area, 0.0, 300.0 * area}), 1e-9);
  const double half = std::sqrt(0.5);
  simulation.set_motion(0, {{0.05, 0.05, 0.05}, {{0.0, {}, {half, half, 0, 0}}}, Interpolation::linear});
  for (int step = 0; step < 3; ++step) simulation.step();
  // A quarter turn about x takes z to -y: the pressure pushes along +y now, the traction as before.
  EXPECT_LT(length(simulation.reaction_of_body(0, {}).force - Vec3{-10.0 * area, -300.0 * area, 0.0}), 1e-9);
}

/// A column under traction at its end follows Hooke; half way up the ramp by half.
TEST(TractionLoad, StretchesAColumnByHookeAndByItsRamp) {
  Model model =
      block({.young_modulus = 1e5, .poisson_ratio = 0.0, .mass_damping = 20.0, .stiffness_damping = 5e-3});
  for (const Vec3& p : model.bodies.points_rest()) model.fixed_points.push_back(p.z == 0.0 ? 1 : 0);
  const std::vector<Index> top = faces(model.bodies, [](const Vec3& p) { return p.z > 0.0999; });
  model.surface_loads.push_back({.triangles = top,
                                 .pressure = 0.0,
                                 .traction = {0.0, 0.0, 1000.0},
                                 .ramp = {.times = {0.0, 0.5, 4.0, 5.0}, .factors = {0.0, 0.5, 0.5, 1.0}}});
  Simulation simulation(std::move(model), weightless(), 2);
  const auto stretch = [&] {
    double highest = 0.0;
    for (const Vec3& p : simulation.positions()) highest = std::max(highest, p.z);
    return highest / 0.1 - 1.0;
  };
  while (simulation.metrics().time < 3.9) simulation.step();
  EXPECT_NEAR(stretch(), 0.005, 1e-5);
  while (simulation.metrics().time < 8.0) simulation.step();
  EXPECT_NEAR(stretch(), 0.01, 1e-5);
}

TEST(Ramp, IsLinearBetweenItsTimesAndConstantOutside) {
  const Ramp ramp{.times = {1.0, 2.0, 4.0}, .factors = {0.5, 1.0, -1.0}};
  for (const auto& [time, factor] : {std::pair(0.0, 0.5), std::pair(1.0, 0.5), std::pair(1.5, 0.75),
                                     std::pair(2.0, 1.0), std::pair(3.0, 0.0), std::pair(9.0, -1.0)})
    EXPECT_DOUBLE_EQ(factor_at(ramp, time), factor) << time;
  EXPECT_EQ(factor_at({}, 3.0), 1.0);
}

TEST(PointLoad, WithARampPushesByNewton) {
  Model model = block();
  std::vector<Index> points;
  for (std::size_t p = 0; p < model.bodies.points_rest().size(); ++p) points.push_back(static_cast<Index>(p));
  model.point_loads.push_back(
      {.points = points, .force = {2.0, 0.0, 0.0}, .ramp = {.times = {0.0, 0.1}, .factors = {0.0, 1.0}}});
  model.materials[0].mass_damping = 0.0;
  Simulation simulation(std::move(model), weightless(), 1);
  double impulse = 0.0;
  double last = 0.05;
  for (int step = 1; step <= 20; ++step) {
    simulation.step();
    impulse += 0.01 * 2.0 * std::min(1.0, 0.01 * step / 0.1);
    // Total momentum, from the displacement of the centre of mass.
    const double momentum = simulation.masses()[0] * (simulation.center_of_mass(0).x - last) / 0.01;
    last = simulation.center_of_mass(0).x;
    EXPECT_NEAR(momentum, impulse, 1e-8) << step;
  }
}

TEST(BodyGravity, TakesThePlaceOfThatOfTheScene) {
  Model model = block();
  model.bodies.add("balloon", test::box_mesh({2, 2, 2}, {0.3, 0, 0}, {0.4, 0.1, 0.1}));
  model.materials.push_back(Material{});
  model.materials[0].mass_damping = 0.0;
  model.gravity_of_body = {std::nullopt, Vec3{0.0, 0.0, 2.0}};
  SimulationSettings settings = weightless();
  settings.gravity = {0.0, 0.0, -9.81};
  Simulation simulation(std::move(model), settings, 1);
  for (int step = 0; step < 10; ++step) simulation.step();
  const double fall = 1e-4 * 55.0;  // implicit Euler's own sum of 10 steps
  EXPECT_NEAR(simulation.center_of_mass(0).z, 0.05 - 9.81 * fall, 1e-9);
  EXPECT_NEAR(simulation.center_of_mass(1).z, 0.05 + 2.0 * fall, 1e-9);
}

TEST(DriveForces, OnManyPointsAreThoseOfTheModel) {
  Model loaded = block();
  loaded.forces.assign(loaded.bodies.points_rest().size(), {});
  std::vector<Index> points;
  std::vector<Vec3> forces;
  for (Index p = 0; p < 60; p += 3) {
    points.push_back(p);
    forces.push_back({0.01 * p, -0.02, 0.03});
    at(loaded.forces, p) = forces.back();
  }
  Simulation a(std::move(loaded), weightless(), 1);
  Simulation b(block(), weightless(), 1);
  b.set_forces(points, forces);
  for (int step = 0; step < 10; ++step) {
    a.step();
    b.step();
  }
  EXPECT_EQ(a.state_hash(), b.state_hash());
  EXPECT_GT(a.metrics().largest_speed, 0.01);
}

TEST(DriveForces, AddToTheLoadsOfTheModelWithAndWithoutARamp) {
  const std::vector<Index> all = [] {
    std::vector<Index> points(block().bodies.points_rest().size());
    std::ranges::iota_view numbers(Index{0}, static_cast<Index>(points.size()));
    std::ranges::copy(numbers, points.begin());
    return points;
  }();
  const std::vector<Vec3> up(all.size(), {0.0, 0.0, 1.0 / static_cast<double>(all.size())});
  for (const bool ramp : {false, true}) {
    Model model = block();
    model.materials[0].mass_damping = 0.0;
    model.point_loads.push_back({all, {2.0, 0.0, 0.0}, ramp ? Ramp{{0.0}, {1.0}} : Ramp{}});
    Simulation simulation(std::move(model), weightless(), 1);
    simulation.set_forces(all, up);
    simulation.step();
    const Vec3 moved = simulation.center_of_mass(0) - Vec3{0.05, 0.05, 0.05};
    const double per_newton = 0.01 * 0.01 / at(simulation.masses(), 0);  // implicit Euler
    EXPECT_NEAR(moved.x, 2.0 * per_newton, 1e-9 * per_newton) << ramp;
    EXPECT_NEAR(moved.z, 1.0 * per_newton, 1e-9 * per_newton) << ramp;
  }
}

TEST(DrivePressure, IsThatOfTheModelAndPartOfASavedState) {
  Model loaded = block();
  const std::vector<Index> top = faces(loaded.bodies, [](const Vec3& p) { return p.z > 0.0999; });
  loaded.surface_loads.push_back({.triangles = top, .pressure = 100.0});
  Simulation a(std::move(loaded), weightless(), 1);
  Simulation b(block(), weightless(), 1);
  b.set_pressure(top, 70.0);
  b.set_pressure(top, 100.0);
  Simulation c(block(), weightless(), 1);
  c.restore(b.save());
  for (Simulation* s : {&a, &b, &c}) {
    for (int step = 0; step < 10; ++step) s->step();
  }
  EXPECT_LT(length(a.center_of_mass(0) - b.center_of_mass(0)), 1e-12);
  EXPECT_LT(b.center_of_mass(0).z, 0.0499);
  EXPECT_EQ(b.state_hash(), c.state_hash());
  b.set_pressure(top, 0.0);
  EXPECT_NE(error_of([&] { a.restore(b.save()); }), "") << "another simulation: it has other loads";
}

/// A pressure that grows with depth, on each triangle that at its middle: Archimedes, exactly, as a linear
/// pressure on a triangle has the sum of its middle.
TEST(DrivePressure, OfEachTriangleLiftsByTheWeightOfTheLiquid) {
  Simulation simulation(block({.young_modulus = 1e5, .poisson_ratio = 0.3}), weightless(), 1);
  constexpr double weight = 9810.0;  // N/m^3, of water
  const std::vector<Index> triangles = all_faces(simulation.bodies());
  std::vector<double> pressures;
  for (const Index t : triangles) {
    const Triangle& corners = at(simulation.bodies().triangles(), t);
    double depth = 0.3;
    for (const Index p : corners) depth -= at(simulation.positions(), p).z / 3.0;
    pressures.push_back(weight * depth);
  }
  simulation.set_pressure(triangles, pressures);
  simulation.step();
  Vec3 momentum;
  for (std::size_t p = 0; p < simulation.velocities().size(); ++p)
    momentum += simulation.point_masses()[p] * simulation.velocities()[p];
  EXPECT_LT(length(momentum - Vec3{0.0, 0.0, 0.01 * weight * 1e-3}), 1e-9) << momentum.z;
  // A triangle that is given twice has the last pressure.
  Simulation other(block({.young_modulus = 1e5, .poisson_ratio = 0.3}), weightless(), 1);
  std::vector<Index> twice = triangles;
  twice.insert(twice.end(), triangles.begin(), triangles.end());
  std::vector<double> values(triangles.size(), 77.0);
  values.insert(values.end(), pressures.begin(), pressures.end());
  other.set_pressure(twice, values);
  other.step();
  EXPECT_EQ(other.state_hash(), simulation.state_hash());
}

TEST(DriveForces, OnAPointThatIsGivenTwiceTheLastHolds) {
  Simulation a(block(), weightless(), 1);
  Simulation b(block(), weightless(), 1);
  a.set_forces(std::vector<Index>{3, 4, 3}, std::vector<Vec3>{{5, 0, 0}, {0, 1, 0}, {0, 0, 2}});
  b.set_forces(std::vector<Index>{4, 3}, std::vector<Vec3>{{0, 1, 0}, {0, 0, 2}});
  a.step();
  b.step();
  EXPECT_EQ(a.state_hash(), b.state_hash());
}

TEST(DrivePositions, OfRigidBodiesAreRefusedUntilTheyAreReleased) {
  Model model = block();
  model.bodies.add("wall", test::box_mesh({2, 2, 2}, {-0.1, -0.1, -0.3}, {0.2, 0.2, -0.2}));
  model.materials.push_back(Material{.young_modulus = 1e5});
  model.obstacles = {0, 1};
  Simulation simulation(std::move(model), weightless(), 1);
  EXPECT_FALSE(simulation.is_rigid(0));
  EXPECT_TRUE(simulation.is_rigid(1));
  EXPECT_EQ(error_of([&] { static_cast<void>(simulation.is_rigid(2)); }),
            "simulation: body: found 2, expected less than 2");
  const Range wall = simulation.bodies().bodies()[1].points;
  const std::string before = simulation.state_hash();
  const std::vector<Index> points{0, wall.begin + 3};
  const std::vector<Vec3> places{{0.0, 0.0, 0.01}, {0.0, 0.0, 0.0}};
  EXPECT_EQ(
      error_of([&] { simulation.set_positions(points, places); }),
      "simulation: positions: found point " + std::to_string(wall.begin + 3) +
          " of the rigid body 'wall', expected points of bodies that deform, or a motion that moves the "
          "whole body");
  EXPECT_EQ(simulation.state_hash(), before);
  simulation.change(ModelChange{.release_bodies = {1}});
  EXPECT_FALSE(simulation.is_rigid(1));
  const Vec3 moved = at(simulation.positions(), wall.begin + 3) + Vec3{0.0, 0.0, 0.001};
  simulation.set_positions(std::vector<Index>{wall.begin + 3}, std::vector<Vec3>{moved});
  EXPECT_EQ(at(simulation.positions(), wall.begin + 3), moved);
}

TEST(DrivePositions, MoveABodyIntoAnotherAtOnce) {
  Model model = block();
  model.bodies.add("plate", test::box_mesh({3, 3, 1}, {-0.1, -0.1, -0.3}, {0.2, 0.2, -0.2}));
  model.materials.push_back(Material{});
  model.obstacles = {0, 1};
  Simulation simulation(std::move(model), weightless(), 1);
  EXPECT_EQ(simulation.metrics().detection.contacts, 0U);
  std::vector<Index> points;
  std::vector<Vec3> places;
  std::vector<Vec3> velocities;
  const Range range = simulation.bodies().bodies()[0].points;
  for (Index p = range.begin; p < range.end; ++p) {
    points.push_back(p);
    places.push_back(at(simulation.positions(), p) - Vec3{0.0, 0.0, 0.201});
    velocities.push_back({0.5, 0.0, 0.0});
  }
  simulation.set_positions(points, places);
  EXPECT_GE(simulation.metrics().detection.contacts, 25U) << "the lowest points of the block";
  EXPECT_NEAR(simulation.metrics().deepest, 0.001, 1e-12);
  simulation.set_velocities(points, velocities);
  EXPECT_NEAR(simulation.metrics().kinetic_energy, 0.5 * simulation.masses()[0] * 0.25, 1e-12);
  simulation.step();
  EXPECT_GT(simulation.contact_wrench(0).force.z, 0.1);
}

TEST(Drive, RefusesWhatIsOutOfRangeAndChangesNothing) {
  Model model = block();
  model.bodies.add("plate", test::box_mesh({1, 1, 1}, {-0.1, -0.1, -0.3}, {0.2, 0.2, -0.2}));
  model.materials.push_back(Material{});
  model.obstacles = {0, 1};
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  model.fixed_points[0] = 1;
  model.motions.push_back({{}, {{0.0, {}, {1, 0, 0, 0}}}, Interpolation::linear});
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  const Index rail = model.bodies.bodies()[1].points.begin;
  at(model.motion_of_point, rail) = 0;
  const Index rigid_face = model.bodies.bodies()[1].triangles.begin;
  Simulation simulation(std::move(model), weightless(), 1);
  const std::string before = simulation.state_hash();
  const Vec3 nowhere{NAN, 0, 0};
  const auto one = [](Index p) { return std::vector<Index>{p}; };
  const auto vec = [](const Vec3& v) { return std::vector<Vec3>{v}; };
  EXPECT_EQ(error_of([&] { simulation.set_forces(one(999), vec({})); }),
            "simulation: point: found 999, expected less than 133");
  EXPECT_EQ(error_of([&] { simulation.set_forces(one(1), {}); }),
            "simulation: forces: found 0 values, expected 1");
  EXPECT_EQ(error_of([&] { simulation.set_forces(one(1), vec(nowhere)); }),
            "simulation: force: found a number that is not finite, expected three finite numbers");
  EXPECT_EQ(error_of([&] { simulation.set_pressure(one(rigid_face), 1.0); }),
            "simulation: triangles: found triangle " + std::to_string(rigid_face) +
                " of the rigid body 'plate', expected a triangle of a body that deforms");
  EXPECT_EQ(error_of([&] { simulation.set_pressure(one(0), NAN); }),
            "simulation: pressure: found a number that is not finite, expected a finite number");
  EXPECT_EQ(error_of([&] {
              simulation.set_pressure(one(0), std::vector<double>{1.0, 2.0});
            }),
            "simulation: pressure: found 2 values, expected 1");
  EXPECT_EQ(
      error_of([&] { simulation.set_pressure(one(0), std::vector<double>{NAN}); }),
      "simulation: pressure: found a number that is not finite, for triangle 0, expected finite numbers");
  EXPECT_NE(error_of([&] { simulation.set_pressure(one(rigid_face), std::vector<double>{1.0}); }), "");
  EXPECT_EQ(error_of([&] { simulation.set_positions(one(rail), vec({})); }),
            "simulation: positions: found point " + std::to_string(rail) +
                ", which has a prescribed motion, expected points that no motion moves");
  EXPECT_EQ(error_of([&] { simulation.set_positions(one(0), vec(nowhere)); }),
            "simulation: positions: found a number that is not finite, expected three finite numbers");
  EXPECT_EQ(
      error_of([&] { simulation.set_velocities(one(0), vec({})); }),
      "simulation: velocities: found point 0, which does not move freely, expected points that are neither "
      "fixed nor prescribed");
  EXPECT_EQ(simulation.state_hash(), before);
  const auto refused = [&](SurfaceLoad load) {
    Model bad = block();
    bad.surface_loads.push_back(std::move(load));
    return error_of([&] { Simulation(std::move(bad), weightless(), 1); });
  };
  EXPECT_EQ(refused({.triangles = {3, 3}, .pressure = 1.0}),
            "loads: surface_loads[0].triangles: found triangle 3 twice, expected each triangle once");
  EXPECT_EQ(refused({.triangles = {3}, .ramp = {.times = {1.0, 1.0}, .factors = {0, 1}}}),
            "loads: surface_loads[0].ramp.times[1]: found 1, expected more than the time before, 1");
  EXPECT_EQ(refused({.triangles = {3}, .ramp = {.times = {1.0}, .factors = {}}}),
            "loads: surface_loads[0].ramp.factors: found 0 values, expected 1");
}

/// A strap of 0.2 m x 20 x 2 mm and 50 MPa is held at one end, and pulled by a force at the other. Hooke: it
/// rests with the energy F^2 L / (2 E A). Without geometric stiffness, or with too little, thin straps
/// vibrated without end in a band of forces, with up to 64,000 times this energy, although all steps
/// converged.
TEST(Loads, AStrapThatIsPulledByAForceComesToRest) {
  constexpr double modulus = 5e7;
  constexpr Vec3 size{0.2, 0.02, 0.002};
  const auto pull = [&](double force, int layers) {
    Model model;
    model.bodies.add("strap", test::box_mesh({60, 2, layers}, {}, size));
    model.materials = {{.young_modulus = modulus, .poisson_ratio = 0.3, .mass_damping = 5.0}};
    const std::span<const Vec3> points = model.bodies.points_rest();
    model.fixed_axes.assign(points.size(), 0);
    PointLoad load{.points = {}, .force = {force, 0.0, 0.0}, .ramp = {{0.0, 0.3}, {0.0, 1.0}}};
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (points[p].x == 0.0) model.fixed_axes[p] = 7;
      if (points[p].x > 0.999 * size.x) load.points.push_back(static_cast<Index>(p));
    }
    model.point_loads = {load};
    SimulationSettings settings;
    settings.time_step = 0.005;
    Simulation simulation(model, settings, 1);
    double fastest = 0.0;
    for (int step = 0; step < 300; ++step) {
      const StepMetrics& m = simulation.step();
      if (step >= 200) fastest = std::max(fastest, m.largest_speed);
    }
    EXPECT_LT(fastest, 1e-3) << force << " N, " << layers << " layers";
    const double energy = force * force * size.x / (2.0 * modulus * size.y * size.z);
    EXPECT_NEAR(simulation.metrics().elastic_energy, energy, 0.02 * energy) << force << " N";
  };
  for (const double force : {4.0, 6.0, 9.1, 12.0, 20.0}) pull(force, 1);
  pull(9.1, 2);
}

}  // namespace
}  // namespace palpate

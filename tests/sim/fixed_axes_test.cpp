// Points that are fixed along some axes of the world. Oracles: Hooke's law in the corotational form, weights,
// Newton, and completely fixed points.
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>
#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "sim/exact_runs.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

using test::exact_settings;
using test::g;
using test::run_to_rest;
using test::sum_of;

constexpr Vec3 size{0.1, 0.04, 0.06};
constexpr double young = 1e5;
constexpr double poisson = 0.3;

/// An eighth of a bar: its mesh is uneven inside, its planes of symmetry are those through the origin.
Model eighth_of_a_bar() {
  TetMesh mesh = test::box_mesh({5, 3, 4}, {0, 0, 0}, size);
  test::Random random(7);
  for (Vec3& p : mesh.points) {
    const bool inside = p.x > 0.0 && p.x < size.x && p.y > 0.0 && p.y < size.y && p.z > 0.0 && p.z < size.z;
    if (inside) p += 0.002 * Vec3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  }
  Model model;
  model.bodies.add("bar", mesh);
  model.materials = {Material{
      .young_modulus = young, .poisson_ratio = poisson, .mass_damping = 20.0, .stiffness_damping = 5e-3}};
  for (const Vec3& p : model.bodies.points_rest())
    model.fixed_axes.push_back(
        static_cast<std::uint8_t>((p.x == 0.0 ? 1 : 0) + (p.y == 0.0 ? 2 : 0) + (p.z == 0.0 ? 4 : 0)));
  return model;
}

/// Surface triangles whose corners all lie in the plane x = size.x.
std::vector<Index> end_face(const Bodies& bodies) {
  std::vector<Index> found;
  for (std::size_t t = 0; t < bodies.triangles().size(); ++t) {
    bool all = true;
    for (const Index p : bodies.triangles()[t]) all = all && at(bodies.points_rest(), p).x == size.x;
    if (all) found.push_back(static_cast<Index>(t));
  }
  return found;
}

SimulationSettings weightless(Preconditioner preconditioner) {
  SimulationSettings settings = exact_settings();
  settings.gravity = {};
  settings.solver.preconditioner = preconditioner;
  settings.rest.speed = 1e-9;
  return settings;
}

class ReactionAtFixedAxes : public ::testing::TestWithParam<Preconditioner> {};

/// Hooke for the corotational law: nominal stress t gives the stretch a = 1 + t / E, and b = 1 - nu (a - 1)
/// across. The plane across x carries the load, the others nothing.
TEST_P(ReactionAtFixedAxes, AreThoseOfAPlaneOfSymmetry) {
  Model model = eighth_of_a_bar();
  constexpr double traction = 2e4;
  model.surface_loads.push_back(
      {.triangles = end_face(model.bodies), .pressure = 0.0, .traction = {traction, 0.0, 0.0}});
  Simulation simulation(std::move(model), weightless(GetParam()), 2);
  simulation.record_reactions(true);
  run_to_rest(simulation, 4000);
  const double along = 1.0 + traction / young;
  const double across = 1.0 - poisson * (along - 1.0);
  const auto rest = simulation.bodies().points_rest();
  Vec3 planes;
  for (std::size_t p = 0; p < rest.size(); ++p) {
    const Vec3& x = simulation.positions()[p];
    ASSERT_LT(length(x - Vec3{along * rest[p].x, across * rest[p].y, across * rest[p].z}), 1e-7 * size.x)
        << p;
    const Vec3& held = simulation.reactions()[p];
    if (rest[p].x == 0.0) {
      ASSERT_EQ(x.x, 0.0) << "bit for bit";
    } else {
      ASSERT_EQ(held.x, 0.0) << "free along x";
    }
    planes += Vec3{std::abs(held.x), std::abs(held.y), std::abs(held.z)};
  }
  const double load = traction * size.y * size.z;
  EXPECT_NEAR(sum_of(simulation.reactions()).x, -load, 1e-6 * load);
  EXPECT_NEAR(planes.x, load, 1e-6 * load) << "all of one sign: the stress is uniform";
  EXPECT_NEAR(planes.y + planes.z, 0.0, 1e-5 * load);
  const TissueState tissue = simulation.tissue();
  for (std::size_t t = 0; t < tissue.size(); ++t) {
    ASSERT_NEAR(tissue.stress[t].xx, traction / (across * across), 1e-5 * traction) << t;
    ASSERT_NEAR(tissue.stress[t].yy, 0.0, 1e-5 * traction);
  }
}

INSTANTIATE_TEST_SUITE_P(Preconditioners, ReactionAtFixedAxes,
                         ::testing::Values(Preconditioner::jacobi, Preconditioner::multigrid),
                         [](const auto& tested) {
                           return tested.param == Preconditioner::jacobi ? "Jacobi" : "Multigrid";
                         });

/// A block on rollers: they carry its weight, and it keeps its speed.
TEST(ReactionOfRollers, IsTheWeightWhileTheBlockGlides) {
  Model model;
  model.bodies.add("block", test::box_mesh({4, 3, 3}, {0, 0, 0}, {0.08, 0.06, 0.06}));
  model.materials = {Material{.young_modulus = 5e4, .stiffness_damping = 2e-2}};
  for (const Vec3& p : model.bodies.points_rest()) {
    model.fixed_axes.push_back(p.z == 0.0 ? 4 : 0);
    model.velocities.push_back({0.3, -0.1, 0.2});
  }
  Simulation simulation(std::move(model), exact_settings(), 2);
  simulation.record_reactions(true);
  const Vec3 start = simulation.center_of_mass(0);
  constexpr int steps = 300;
  double impulse = 0.0;
  for (int step = 0; step < steps; ++step) {
    simulation.step();
    impulse += 0.01 * sum_of(simulation.reactions()).z;
    ASSERT_TRUE(simulation.metrics().solver_converged);
  }
  const double weight = g * simulation.masses()[0];
  const Vec3 held = sum_of(simulation.reactions());
  EXPECT_NEAR(held.z, weight, 1e-5 * weight);
  EXPECT_EQ(held.x, 0.0);
  const double time = 0.01 * steps;
  const Vec3 moved = simulation.center_of_mass(0) - start;
  EXPECT_NEAR(moved.x, 0.3 * time, 1e-6 * 0.3 * time);
  EXPECT_NEAR(moved.y, -0.1 * time, 1e-6 * 0.3 * time);
  for (std::size_t p = 0; p < simulation.positions().size(); ++p) {
    if (simulation.bodies().points_rest()[p].z == 0.0) {
      ASSERT_EQ(simulation.positions()[p].z, 0.0);
      ASSERT_EQ(simulation.velocities()[p].z, 0.0);
    }
  }
  // Newton for the whole block: impulse of the rollers = impulse of the weight minus the first momentum
  // (points on rollers have no momentum along z).
  double momentum = 0.0;
  for (const Tet& t : simulation.bodies().tets()) {
    const auto corner = [&](std::size_t i) { return at(simulation.bodies().points_rest(), t[i]); };
    const double six = dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0));
    for (const Index p : t) {
      if (at(simulation.bodies().points_rest(), p).z != 0.0) momentum += 0.2 * 1000.0 * six / 24.0;
    }
  }
  EXPECT_NEAR(impulse, weight * time - momentum, 1e-5 * weight * time);
}

/// A block between two plates, loaded by its weight, with rollers at a side: friction and contacts together
/// with fixed axes.
TEST(ReactionOfRollers, GoWithContacts) {
  Model model;
  model.bodies.add("floor", test::box_mesh({2, 2, 1}, {-0.1, -0.1, -0.02}, {0.2, 0.2, 0}));
  model.bodies.add("block", test::box_mesh({3, 3, 3}, {0, 0, 1e-4}, {0.06, 0.06, 0.0601}));
  model.materials = {Material{},
                     Material{.young_modulus = 5e4, .mass_damping = 5.0, .stiffness_damping = 1e-2}};
  model.obstacles = {1, 0};
  const auto rest = model.bodies.points_rest();
  for (std::size_t p = 0; p < rest.size(); ++p)
    model.fixed_axes.push_back(
        p >= static_cast<std::size_t>(model.bodies.bodies()[1].points.begin) && rest[p].x == 0.0 ? 1 : 0);
  SimulationSettings settings = exact_settings();
  settings.gravity = {-3.0, 0.0, -g};
  settings.response.friction = 0.1;
  settings.rest.speed = 1e-6;
  Simulation simulation(std::move(model), settings, 1);
  simulation.record_reactions(true);
  run_to_rest(simulation, 3000);
  const double mass = simulation.masses()[1];
  const Vec3 contacts = simulation.contact_forces()[1];
  const Vec3 held = simulation.reaction_of_body(1, {}).force;
  EXPECT_NEAR(contacts.z, g * mass, 1e-3 * g * mass);
  EXPECT_NEAR(held.x + contacts.x, 3.0 * mass, 1e-3 * g * mass);
  EXPECT_EQ(held.z, 0.0);
  EXPECT_LE(std::hypot(contacts.x, contacts.y), 0.1001 * contacts.z);
}

/// Fixing all three axes gives the same bits as fixing the point.
TEST(FixedAxes, AllThreeAreAFixedPoint) {
  const auto hash = [](bool by_axes) {
    Model model;
    model.bodies.add("beam", test::box_mesh({4, 2, 2}, {0, 0, 0}, {0.1, 0.04, 0.04}));
    model.materials = {Material{.young_modulus = 1e5}};
    for (const Vec3& p : model.bodies.points_rest())
      (by_axes ? model.fixed_axes : model.fixed_points).push_back(p.x == 0.0 ? (by_axes ? 7 : 1) : 0);
    Simulation simulation(std::move(model), {}, 1);
    for (int step = 0; step < 10; ++step) simulation.step();
    return simulation.state_hash();
  };
  EXPECT_EQ(hash(true), hash(false));
}

TEST(FixedAxes, HaveTheSameBitsForEveryThreadCountAndWhenResumed) {
  const auto make = [](int threads) {
    Model model = eighth_of_a_bar();
    model.velocities.assign(model.fixed_axes.size(), {1.0, 2.0, 3.0});
    return Simulation(std::move(model), {}, threads);
  };
  Simulation one = make(1);
  Simulation three = make(3);
  for (int step = 0; step < 6; ++step) one.step();
  const std::vector<std::byte> saved = one.save();
  for (int step = 0; step < 6; ++step) one.step();
  for (int step = 0; step < 12; ++step) three.step();
  EXPECT_EQ(one.state_hash(), three.state_hash());
  three.restore(saved);
  for (int step = 0; step < 6; ++step) three.step();
  EXPECT_EQ(one.state_hash(), three.state_hash());
}

TEST(FixedAxes, AreKeptWhereOverlapsAreRemoved) {
  Model model;
  model.bodies.add("lower", test::box_mesh({3, 3, 3}, {0, 0, 0}, {0.06, 0.06, 0.06}));
  model.bodies.add("upper", test::box_mesh({3, 3, 3}, {0.002, 0.004, 0.055}, {0.062, 0.064, 0.115}));
  model.materials = {Material{.young_modulus = 1e4}, Material{.young_modulus = 1e4}};
  const auto rest = model.bodies.points_rest();
  const std::vector<Vec3> before(rest.begin(), rest.end());
  for (const Vec3& p : before) model.fixed_axes.push_back(p.z == 0.0 ? 4 : (p.z == 0.115 ? 6 : 0));
  SimulationSettings settings;
  settings.gravity = {};
  const RelaxReport report = relax(model, settings, {}, 1);
  EXPECT_TRUE(report.relaxed);
  EXPECT_GT(report.largest_move, 1e-4);
  for (std::size_t p = 0; p < before.size(); ++p) {
    const Vec3& now = model.bodies.points_rest()[p];
    const Vec3 moved = now - before[p];
    EXPECT_EQ((model.fixed_axes[p] & 4) != 0 ? moved.z : 0.0, 0.0) << p;
    EXPECT_EQ((model.fixed_axes[p] & 2) != 0 ? moved.y : 0.0, 0.0) << p;
  }
}

TEST(FixedAxes, RefuseWhatMovesAlongThem) {
  const auto message = [](auto&& call) -> std::string {
    try {
      call();
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  Model model = eighth_of_a_bar();
  const Index corner = 0;  // at the origin: all axes
  const Index edge = 1;    // along x: fixed in y and z
  Simulation simulation(Model(model), {}, 1);
  const auto set = [&](Index point, const Vec3& velocity) {
    return message([&] { simulation.set_velocities(std::array{point}, std::array{velocity}); });
  };
  EXPECT_EQ(
      set(corner, {1, 0, 0}),
      "simulation: velocities: found point 0, which does not move freely, expected points that are neither "
      "fixed nor prescribed");
  EXPECT_EQ(set(edge, {1, 0, 0}), "accepted");
  EXPECT_EQ(set(edge, {1, 1e-9, 0}),
            "simulation: velocities: found point 1, which moves along an axis that is fixed, expected a "
            "velocity of zero along it");
  model.fixed_axes[3] = 8;
  EXPECT_EQ(message([&] { Simulation(Model(model), {}, 1); }),
            "simulation: fixed_axes[3]: found 8, expected a sum of 1 (x), 2 (y) and 4 (z)");
  model.fixed_axes.pop_back();
  EXPECT_NE(message([&] { Simulation(Model(model), {}, 1); }).find("fixed_axes: found"), std::string::npos);
}

}  // namespace
}  // namespace palpate

// The medical scenes as a user runs them, until rest. Oracle: the statements of docs/anatomy.md.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <set>
#include <span>
#include <string>
#include <utility>

#include <palpate/io/mesh_reader.hpp>
#include <palpate/relax.hpp>
#include <palpate/simulation.hpp>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/scene.hpp"
#include "support/mean.hpp"

namespace palpate {
namespace {

Scene medical_scene(const std::string& name) {
  return read_scene(std::filesystem::path(PALPATE_SOURCE_DIR) / "scenes" / (name + ".json"));
}

struct Prepared {
  Simulation simulation;
  RelaxReport relaxed;
};

Prepared prepare(const Scene& scene, int threads) {
  Model model = load_model(scene, [](const auto& path) { return io::read_mesh(path).mesh; });
  const RelaxReport relaxed = relax(model, scene.settings, *scene.relax, threads);
  return {Simulation(std::move(model), scene.settings, threads), relaxed};
}

Index body_named(const Simulation& simulation, const std::string& name) {
  const auto bodies = simulation.bodies().bodies();
  const auto body = std::ranges::find(bodies, name, &Body::name);
  EXPECT_NE(body, bodies.end()) << name;
  return static_cast<Index>(body - bodies.begin());
}

Vec3 mean_displacement(const Simulation& simulation, const std::string& body) {
  const Index b = body_named(simulation, body);
  return test::mean_of_body(simulation.bodies(), b, simulation.positions()) -
         test::mean_of_body(simulation.bodies(), b, simulation.bodies().points_rest());
}

int inverted_tets(const Simulation& simulation) {
  int count = 0;
  for (const Tet& t : simulation.bodies().tets()) {
    const auto corner = [&](std::size_t i) { return at(simulation.positions(), t[i]); };
    count += orient3d(corner(0), corner(1), corner(2), corner(3)) > 0 ? 0 : 1;
  }
  return count;
}

std::set<std::pair<std::string, std::string>> touching(const Simulation& simulation) {
  std::set<std::pair<std::string, std::string>> pairs;
  const Contacts& contacts = simulation.detector().contacts();
  const auto bodies = simulation.bodies().bodies();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const std::string& a = at(bodies, at(simulation.bodies().body_of_point(), contacts.point[c])).name;
    const std::string& b = at(bodies, contacts.body[c]).name;
    pairs.insert(std::minmax(a, b));
  }
  return pairs;
}

double mean_edge(const Simulation& simulation) {
  return mesh_statistics(simulation.bodies(), simulation.bodies().points_rest()).edge_length.mean;
}

/// Runs to rest, before the scene's duration. Then checks that hold for both scenes.
Prepared run_to_rest(const Scene& scene) {
  Prepared prepared = prepare(scene, 2);
  Simulation& simulation = prepared.simulation;
  EXPECT_TRUE(prepared.relaxed.relaxed) << "no overlap is left at the start";
  bool converged = true;
  while (!simulation.at_rest() && simulation.metrics().time < scene.duration) {
    simulation.step();
    converged = converged && simulation.metrics().solver_converged;
  }
  EXPECT_TRUE(converged);
  EXPECT_TRUE(simulation.at_rest());
  EXPECT_LE(simulation.metrics().fastest_body, scene.settings.rest.speed);
  EXPECT_EQ(inverted_tets(simulation), 0);
  EXPECT_LT(simulation.metrics().deepest, 0.05 * mean_edge(simulation));
  return prepared;
}

TEST(EyeScene, ThePlateLiftsTheBulbAndAllTissuesTouch) {
  const Prepared prepared = run_to_rest(medical_scene("eye"));
  const Simulation& simulation = prepared.simulation;
  EXPECT_NEAR(length(mean_displacement(simulation, "plate") - Vec3{0, 2, 3}), 0.0, 1e-9);
  const Vec3 bulb = mean_displacement(simulation, "bulb");
  EXPECT_GT(bulb.z, 0.8);
  EXPECT_LT(bulb.z, 3.0) << "less than the plate rises";
  EXPECT_LT(bulb.y, 0.0) << "and forwards, out of the cone";
  EXPECT_LT(std::abs(bulb.x), 0.3) << "the orbit is the same on both sides";
  const auto pairs = touching(simulation);
  for (const std::string other : {"bone", "bulb", "inferior rectus", "lateral rectus", "medial rectus",
                                  "optic nerve", "plate", "skin", "superior rectus"}) {
    EXPECT_TRUE(pairs.contains(std::minmax(std::string("fat"), other))) << other;
  }
}

/// Where the walk along an edge left the body for a moment, the force of its inset ended: points trembled in
/// cycles of four steps.
TEST(EyeScene, ComesToRestWithOtherTimeSteps) {
  for (const double time_step : {0.006, 0.007, 0.008, 0.009}) {
    SCOPED_TRACE(time_step);
    Scene scene = medical_scene("eye");
    scene.settings.time_step = time_step;
    const Prepared prepared = run_to_rest(scene);
    double fastest = 0.0;
    for (const Vec3& v : prepared.simulation.velocities()) fastest = std::max(fastest, length(v));
    EXPECT_LT(fastest, 0.3) << "mm/s";
  }
}

/// Rotation of the bulb's front about its centre towards x, the left, in degrees.
double turned_left(const Simulation& simulation) {
  const Index bulb = body_named(simulation, "bulb");
  const auto rest = simulation.bodies().points_rest();
  const Range points = at(simulation.bodies().bodies(), bulb).points;
  Index front = points.begin;
  for (Index p = points.begin; p < points.end; ++p)
    if (at(rest, p).y < at(rest, front).y) front = p;
  const auto angle = [&](std::span<const Vec3> positions) {
    const Vec3 arm = at(positions, front) - test::mean_of_body(simulation.bodies(), bulb, positions);
    return std::atan2(arm.x, -arm.y);
  };
  return (angle(simulation.positions()) - angle(rest)) * 180.0 / 3.14159265358979323846;
}

/// The first 0.3 s of the contraction; at their end the tension is at 30 %.
TEST(EyeScene, TheActiveLateralRectusTurnsTheBulbToItsSide) {
  Prepared prepared = prepare(medical_scene("eye-recti"), 2);
  Simulation& simulation = prepared.simulation;
  const Index muscle = body_named(simulation, "lateral rectus");
  EXPECT_GT(test::mean_of_body(simulation.bodies(), muscle, simulation.bodies().points_rest()).x, 5.0);
  while (simulation.metrics().time < 0.3 - 1e-9) {
    simulation.step();
    EXPECT_TRUE(simulation.metrics().solver_converged) << "step " << simulation.metrics().step;
    EXPECT_EQ(inverted_tets(simulation), 0) << "step " << simulation.metrics().step;
  }
  EXPECT_GT(turned_left(simulation), 5.0);
}

TEST(SkullScene, SoftTissueFollowsTheJaws) {
  const Prepared prepared = run_to_rest(medical_scene("skull"));
  const Simulation& simulation = prepared.simulation;
  EXPECT_NEAR(length(mean_displacement(simulation, "lower jaw") - Vec3{0, -5, 0}), 0.0, 1e-9);
  EXPECT_NEAR(length(mean_displacement(simulation, "upper jaw") - Vec3{0, -3, 0}), 0.0, 1e-9);
  // The skin of the chin moves with the lower jaw, the forehead's stays, and no point moves much further than
  // a jaw.
  const Range points = at(simulation.bodies().bodies(), body_named(simulation, "soft tissue")).points;
  double largest = 0.0;
  for (Index p = points.begin; p < points.end; ++p) {
    const Vec3& rest = at(simulation.bodies().points_rest(), p);
    const Vec3 moved = at(simulation.positions(), p) - rest;
    largest = std::max(largest, length(moved));
    if (rest.z < -80.0 && rest.y < -60.0) {
      EXPECT_NEAR(moved.y, -5.0, 1.0);
    }
    if (rest.z > 30.0) {
      EXPECT_LT(length(moved), 0.5);
    }
  }
  EXPECT_LT(largest, 6.0);
  const auto pairs = touching(simulation);
  EXPECT_TRUE(pairs.contains({"lower jaw", "soft tissue"}));
  EXPECT_TRUE(pairs.contains({"soft tissue", "upper jaw"}));
}

TEST(MedicalScenes, HaveTheSameBitsForEveryThreadCount) {
  for (const std::string name : {"eye", "skull"}) {
    const Scene scene = medical_scene(name);
    std::set<std::string> hashes;
    for (const int threads : {1, 2}) {
      Simulation simulation = prepare(scene, threads).simulation;
      for (int i = 0; i < 5; ++i) simulation.step();
      hashes.insert(simulation.state_hash());
    }
    EXPECT_EQ(hashes.size(), 1U) << name;
  }
}

}  // namespace
}  // namespace palpate

// A step that must fail: its message, and that the state has not changed.
#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <optional>
#include <string>

#include <palpate/error.hpp>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// A plate that stands still, then a ball of one tet, then a box: the one that breaks is not the first.
Bodies three_bodies() {
  Bodies bodies;
  bodies.add("plate", box_mesh({1, 1, 1}, {1.0, 1.0, 0.1}));
  bodies.add("drop", unit_tet_mesh(0.1));
  bodies.add("box", box_mesh({2, 2, 2}, {0.2, 0.2, 0.2}));
  return bodies;
}

Dynamics dynamics_of(const Bodies& bodies) {
  return Dynamics(bodies, std::vector<Material>(3), std::vector<std::uint8_t>(bodies.points_rest().size()),
                  {1, 0, 0}, parallel::Threads(2));
}

TEST(Breakdown, AForceThatIsNotFiniteNamesBodyAndTet) {
  const Bodies bodies = three_bodies();
  Dynamics dynamics = dynamics_of(bodies);
  std::vector<Vec3> forces(bodies.points_rest().size());
  const Index point = bodies.bodies()[2].points.begin + 26;
  at(forces, point).y = std::numeric_limits<double>::quiet_NaN();
  const Index tet = at(bodies.bodies(), 2).tets.end;
  const std::string message = message_of([&] { dynamics.step(0.01, {}, forces, {}, 1e-6, 100); });
  // The lowest tet at that corner, found here by search.
  Index first = at(bodies.bodies(), 2).tets.begin;
  while (first < tet && std::ranges::count(at(bodies.tets(), first), point) == 0) ++first;
  EXPECT_EQ(message,
            "body box: tet " + std::to_string(first - at(bodies.bodies(), 2).tets.begin) +
                ": found a force that is not finite, expected finite forces, positions and velocities");
}

TEST(Breakdown, NumbersThatOverflowInTheSolverNameWhereTheyBegan) {
  const Bodies bodies = three_bodies();
  Dynamics dynamics = dynamics_of(bodies);
  std::vector<Vec3> forces(bodies.points_rest().size());
  at(forces, bodies.bodies()[1].points.begin + 2).y = 1e300;
  const std::string message = message_of([&] { dynamics.step(0.01, {}, forces, {}, 1e-6, 100); });
  EXPECT_TRUE(message.starts_with("body drop: tet 0: found a velocity that is not finite")) << message;
  EXPECT_TRUE(std::ranges::equal(dynamics.positions(), bodies.points_rest()));
}

TEST(Breakdown, SpeedAboveTheLimitNamesTheFastestPoint) {
  const Bodies bodies = three_bodies();
  Dynamics dynamics = dynamics_of(bodies);
  std::vector<Vec3> velocities(bodies.points_rest().size(), {0.0, 0.3, 0.4});
  for (Index p = 0; p < 4; ++p) at(velocities, bodies.bodies()[1].points.begin + p) = {0.0, 3.0, 4.0};
  dynamics.set_velocities(velocities);
  dynamics.begin_step(0.01, {}, {});
  dynamics.solve({}, {1e-12, 100});
  EXPECT_EQ(message_of([&] { dynamics.check_limits(5.001, {}); }), "no error");
  const std::string message = message_of([&] { dynamics.check_limits(4.5, {}); });
  const std::string start = "body drop: tet 0: found a speed of ";
  ASSERT_TRUE(message.starts_with(start) && message.ends_with(", expected at most 4.5 (limits.max_speed)"))
      << message;
  EXPECT_NEAR(std::stod(message.substr(start.size())), 5.0, 1e-9);
}

TEST(Breakdown, AnElementThatStaysInvertedIsNamedAndOneThatRecoversIsNot) {
  const Bodies bodies = single_body(box_mesh({1, 1, 1}, {1.0, 1.0, 1.0}));
  const Material usual;
  Dynamics held = Scene{usual, std::vector<std::uint8_t>(8, 1), 1}.dynamics(bodies);
  const auto upright = mapped(bodies, [](const Vec3& p) { return p; });
  const auto step = [&](std::optional<double> most) {
    held.begin_step(0.01, {}, {});
    held.solve({}, {1e-6, 10});
    held.check_limits(1e3, most);
    held.end_step();
  };
  const auto inverted = mapped(bodies, [](const Vec3& p) { return Vec3{p.x, p.y, -p.z}; });
  held.set_positions(inverted);
  for (int n = 0; n < 4; ++n) step(0.04);
  for (const double clock : held.inversion_clocks()) EXPECT_NEAR(clock, 0.04, 1e-12);
  held.set_positions(upright);
  step(0.04);
  for (const double clock : held.inversion_clocks()) EXPECT_LT(clock, 0.0) << "its bulk modulus returns";
  for (int n = 0; n < 31; ++n) step(0.04);
  EXPECT_EQ(std::ranges::count(held.inversion_clocks(), 0.0), 5) << "it has returned";
  held.set_positions(inverted);
  for (int n = 0; n < 4; ++n) step(0.04);
  EXPECT_EQ(message_of([&] { step(0.04); }),
            "body body: tet 0: found an inversion that has lasted 0.04 s, expected less than 0.04 s "
            "(limits.inverted_time)");
  for (const double clock : held.inversion_clocks())
    EXPECT_NEAR(clock, 0.04, 1e-12) << "the state is as it was";
  EXPECT_EQ(message_of([&] { step({}); }), "no error") << "no limit unless asked for";
}

TEST(Breakdown, AStepThatIsNotEndedChangesNothing) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2));
  const Material material{
      .young_modulus = 2e4, .stiffness_damping = 0.002, .plastic_yield = 0.01, .plastic_creep = 10.0};
  std::vector<std::uint8_t> fixed(bodies.points_rest().size(), 0);
  fixed[0] = 1;  // to be moved
  Dynamics dynamics = Scene{material, fixed, 2}.dynamics(bodies);
  Dynamics other = Scene{material, fixed, 2}.dynamics(bodies);
  for (Dynamics* d : {&dynamics, &other}) {
    d->set_positions(noisy(bodies, 0.15, 21));
    for (int n = 0; n < 2; ++n) d->step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 50);
  }
  const auto expect_equal = [&] {
    EXPECT_TRUE(std::ranges::equal(dynamics.positions(), other.positions()));
    EXPECT_TRUE(std::ranges::equal(dynamics.velocities(), other.velocities()));
    EXPECT_TRUE(std::ranges::equal(dynamics.velocity_changes(), other.velocity_changes()));
    EXPECT_TRUE(std::ranges::equal(dynamics.inversion_clocks(), other.inversion_clocks()));
    const auto bits = [](const Dynamics& d) {
      std::vector<double> values;
      for (const auto& p : d.plastic_strains())
        values.insert(values.end(), {p.xx, p.yy, p.zz, p.xy, p.xz, p.yz});
      return values;
    };
    EXPECT_EQ(bits(dynamics), bits(other));
  };
  expect_equal();
  dynamics.prescribe(std::vector<Index>{0}, std::vector<Vec3>{{-0.1, 0.0, 0.0}});
  dynamics.begin_step(0.01, {5.0, 0.0, 0.0}, {});
  dynamics.solve({}, {1e-5, 50});
  EXPECT_FALSE(std::ranges::equal(dynamics.end_positions(), other.positions()));
  expect_equal();
  dynamics.prescribe({}, {});
  dynamics.begin_step(0.01, {0.0, 0.0, -9.81}, {});
  dynamics.solve({}, {1e-5, 50});
  const auto end = dynamics.end_positions();
  const std::vector<Vec3> predicted(end.begin(), end.end());
  dynamics.end_step();
  EXPECT_TRUE(std::ranges::equal(dynamics.positions(), predicted));
  other.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 50);
  EXPECT_GT(*std::ranges::max_element(dynamics.inversion_clocks()), 0.0) << "noise inverts some";
  for (Dynamics* d : {&dynamics, &other})
    for (int n = 0; n < 3; ++n) d->step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 50);
  expect_equal();
}

}  // namespace
}  // namespace palpate::fem::test

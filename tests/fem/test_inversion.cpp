// Tissue that starts inverted, flat or at random positions recovers (docs/inversion.md).
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "fem/meshes.hpp"
#include "support/meshes.hpp"

namespace palpate::fem::test {
namespace {

struct Start {
  std::string name;
  std::vector<Vec3> positions;
};

/// Start positions of a body of about `size` around the origin.
std::vector<Start> starts(const Bodies& bodies, double size, unsigned seed) {
  std::mt19937_64 random(seed);
  const std::size_t count = bodies.points_rest().size();
  const Matrix3 r = random_rotation(random);
  std::vector<Start> all;
  all.push_back({"anywhere", random_vectors(count, 0.5 * size, seed)});
  all.push_back({"noise", noisy(bodies, 0.25 * size, seed)});
  all.push_back({"mirrored", mapped(bodies, [&](const Vec3& p) {
                   const Vec3 q = r * p;
                   return Vec3{q.x, q.y, -q.z};
                 })});
  all.push_back({"flat", mapped(bodies, [&](const Vec3& p) {
                   const Vec3 q = r * p;
                   return Vec3{q.x, q.y, 0.0};
                 })});
  all.push_back({"inside out", mapped(bodies, [](const Vec3& p) { return -p; })});
  Start far{"points far through their neighbours", mapped(bodies, [](const Vec3& p) { return p; })};
  for (int k = 0; k < 3; ++k) far.positions[random() % count] += random_vector(random, 5.0 * size);
  all.push_back(far);
  return all;
}

/// No tet is inverted after `time`, from any start; fixed points stay at rest.
void expect_return(const Bodies& bodies, const Scene& scene, double time_step, double time, unsigned seed) {
  for (Start& start : starts(bodies, 0.3, seed)) {
    for (std::size_t i = 0; i < scene.fixed.size(); ++i) {
      if (scene.fixed[i] != 0) start.positions[i] = bodies.points_rest()[i];
    }
    Dynamics dynamics = scene.dynamics(bodies);
    dynamics.set_positions(start.positions);
    const int steps = static_cast<int>(std::lround(time / time_step));
    for (int n = 0; n < steps; ++n) dynamics.step(time_step, {}, {}, {}, 1e-4, 300);
    EXPECT_EQ(inverted_tets(bodies, dynamics.positions()), 0)
        << start.name << ", nu " << scene.material.poisson_ratio << ", step " << time_step;
  }
}

Material tissue(double poisson_ratio) {
  return {.young_modulus = 2e4, .poisson_ratio = poisson_ratio, .stiffness_damping = 0.002};
}

TEST(Inversion, FreeBodiesComeBackWithinFourSeconds) {
  const Bodies ball = single_body(palpate::test::ball_mesh(4, {0.0, 0.0, 0.0}, 0.15));
  const Bodies box =
      single_body(palpate::test::box_mesh({4, 4, 4}, {-0.15, -0.15, -0.15}, {0.15, 0.15, 0.15}));
  const Bodies tet = single_body(unit_tet_mesh(0.3));
  for (const double nu : {0.0, 0.4, 0.49}) {
    expect_return(ball, {tissue(nu), {}, 1}, 0.01, 4.0, 1);
    expect_return(box, {tissue(nu), {}, 1}, 0.02, 4.0, 2);
    expect_return(tet, {tissue(nu), {}, 1}, 0.01, 4.0, 3);
  }
}

TEST(Inversion, HeldBodiesComeBackWithinSixSeconds) {
  const Bodies ball = single_body(palpate::test::ball_mesh(4, {0.0, 0.0, 0.0}, 0.15));
  const auto face = select(ball, [](const Vec3& p) { return p.z < -0.12; });
  std::vector<std::uint8_t> some(ball.points_rest().size(), 0);
  for (const std::size_t i : {3U, 50U, 71U, 110U}) some[i] = 1;
  for (const double nu : {0.3, 0.49}) {
    expect_return(ball, {tissue(nu), face, 1}, 0.01, 6.0, 4);
    expect_return(ball, {tissue(nu), some, 1}, 0.01, 6.0, 5);
  }
}

TEST(Inversion, SmallStepsComeBackInTheSameTime) {
  const Bodies ball = single_body(palpate::test::ball_mesh(3, {0.0, 0.0, 0.0}, 0.15));
  expect_return(ball, {tissue(0.49), {}, 1}, 0.002, 4.0, 6);
}

TEST(Inversion, KeepsMomentum) {
  const Bodies ball = single_body(palpate::test::ball_mesh(3, {0.0, 0.0, 0.0}, 0.15));
  Dynamics dynamics = Scene{tissue(0.49), {}, 1}.dynamics(ball);
  dynamics.set_positions(noisy(ball, 0.1, 7));
  dynamics.set_velocities(std::vector<Vec3>(ball.points_rest().size(), {1.0, 2.0, -1.0}));
  const Vec3 before = momentum(dynamics);
  for (int n = 0; n < 50; ++n) {
    dynamics.step(0.01, {}, {}, {}, 1e-12, 2000);
    if (n == 2) {
      ASSERT_GT(*std::ranges::max_element(dynamics.inversion_clocks()), 0.0);
    }
    if (n == 20) {
      ASSERT_LT(*std::ranges::min_element(dynamics.inversion_clocks()), 0.0);
    }
  }
  EXPECT_LT(length(momentum(dynamics) - before), 1e-10 * length(before));
}

/// A state saved during recovery continues with the same bits.
TEST(Inversion, ClocksArePartOfTheState) {
  const Bodies ball = single_body(palpate::test::ball_mesh(3, {0.0, 0.0, 0.0}, 0.15));
  Dynamics first = Scene{tissue(0.49), {}, 1}.dynamics(ball);
  first.set_positions(noisy(ball, 0.1, 8));
  for (int n = 0; n < 12; ++n) first.step(0.01, {}, {}, {}, 1e-4, 300);
  ASSERT_GT(*std::ranges::max_element(first.inversion_clocks()), 0.0);
  ASSERT_LT(*std::ranges::min_element(first.inversion_clocks()), 0.0);
  Dynamics second = Scene{tissue(0.49), {}, 2}.dynamics(ball);
  second.set_state(first.state());
  for (int n = 0; n < 20; ++n) {
    first.step(0.01, {}, {}, {}, 1e-4, 300);
    second.step(0.01, {}, {}, {}, 1e-4, 300);
  }
  EXPECT_TRUE(std::ranges::equal(first.positions(), second.positions()));
  EXPECT_TRUE(std::ranges::equal(first.inversion_clocks(), second.inversion_clocks()));
  EXPECT_EQ(first.elastic_energy(), second.elastic_energy());
}

}  // namespace
}  // namespace palpate::fem::test

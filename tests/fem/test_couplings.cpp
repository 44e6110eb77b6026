#include <cmath>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

/// Two tets, the first point of the second opposite a face of the first, as in a contact.
Bodies two_tets() {
  Bodies bodies;
  bodies.add("lower", unit_tet_mesh());
  TetMesh upper = unit_tet_mesh();
  for (Vec3& p : upper.points) p += Vec3{0.2, 0.2, 0.2};
  bodies.add("upper", upper);
  return bodies;
}

Coupling contact() {
  Coupling c;
  c.points = {4, 0, 1, 2, 3};
  c.coefficients = {1.0, -0.4, -0.2, -0.2, -0.2};
  c.force = {0.0, 3.0, 40.0};
  c.stiffness = {0.0, 0.0, 5e3, 0.0, 0.0, 0.0};
  c.damping = {1.0, 1.0, 7.0, 0.0, 0.0, 0.0};
  return c;
}

TEST(Coupling, ForcesOnAllPointsSumToZero) {
  const Bodies bodies = two_tets();
  Dynamics dynamics = Scene{{1e5, 0.3, 1000.0, 0.0, 0.001}, {}, 1}.dynamics(bodies);
  const std::vector<Coupling> couplings{contact()};
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(dynamics.step(0.01, {}, {}, couplings, 1e-13, 500).converged);
  const Vec3 sum = momentum(dynamics);
  EXPECT_GT(dynamics.kinetic_energy(), 1e-4) << "the coupling does nothing";
  EXPECT_LT(length(sum), 1e-11);
}

TEST(Coupling, EndForceIsWhatTheStepUsed) {
  // The coupling acts on the upper tet only: its change of momentum is h times the force on u.
  const Bodies bodies = two_tets();
  Dynamics dynamics = Scene{{1e5, 0.3, 1000.0, 0.0, 0.0}, {}, 1}.dynamics(bodies);
  dynamics.set_velocities(random_vectors(8, 0.5, 31));
  constexpr double h = 0.01;
  const auto upper_momentum = [&] {
    Vec3 sum;
    for (std::size_t i = 4; i < 8; ++i) sum += dynamics.point_masses()[i] * dynamics.velocities()[i];
    return sum;
  };
  const std::vector<Coupling> couplings{contact()};
  const Vec3 before = upper_momentum();
  ASSERT_TRUE(dynamics.step(h, {}, {}, couplings, 1e-14, 500).converged);
  const Vec3 change = upper_momentum() - before;
  const Vec3 force = end_force(couplings[0], h, dynamics.velocities());
  EXPECT_LT(length(change - h * force), 1e-10 * length(change));
  EXPECT_GT(length(force - couplings[0].force), 0.1) << "the velocity has no part";
}

TEST(Coupling, EndForceByHand) {
  Coupling c;
  c.points = {1, 0, -1, -1, -1};
  c.coefficients = {1.0, -0.5, 7.0, 7.0, 7.0};  // unused ones must not be read
  c.force = {1.0, 2.0, 3.0};
  c.stiffness = {100.0, 0.0, 0.0, 10.0, 0.0, 0.0};
  c.damping = {0.0, 0.0, 2.0, 0.0, 0.0, 0.0};
  const std::vector<Vec3> velocities{{2.0, 0.0, 4.0}, {2.0, 1.0, 1.0}};
  // u' = (1, 1, -1); (D + 0.1 S) u' = (11, 1, -2).
  const Vec3 force = end_force(c, 0.1, velocities);
  EXPECT_DOUBLE_EQ(force.x, -10.0);
  EXPECT_DOUBLE_EQ(force.y, 1.0);
  EXPECT_DOUBLE_EQ(force.z, 5.0);
}

/// A stiff tet hangs on a spring between its point 0 and the place where that point was at rest.
TEST(Coupling, AWeightOnASpringFindsForceOverStiffness) {
  const Bodies bodies = single_body(unit_tet_mesh(0.1));
  Dynamics dynamics = Scene{{1e6, 0.3, 1000.0, 0.0, 0.0}, {}, 1}.dynamics(bodies);
  constexpr double k = 50.0;
  const Vec3 anchor = bodies.points_rest()[0];
  // Springs on all points alike keep the tet upright.
  for (int i = 0; i < 4000; ++i) {
    std::vector<Coupling> springs;
    for (Index p = 0; p < 4; ++p) {
      const auto place = static_cast<std::size_t>(p);
      Coupling c;
      c.points[0] = p;
      c.coefficients[0] = 1.0;
      c.force = k * (bodies.points_rest()[place] - dynamics.positions()[place]);
      c.stiffness = {k, k, k, 0.0, 0.0, 0.0};
      c.damping = {0.5, 0.5, 0.5, 0.0, 0.0, 0.0};
      springs.push_back(c);
    }
    ASSERT_TRUE(dynamics.step(0.01, standard_gravity, {}, springs, 1e-10, 500).converged);
  }
  const double weight = 1000.0 * 1e-3 / 6.0 * 9.81;
  EXPECT_NEAR(anchor.z - dynamics.positions()[0].z, weight / (4.0 * k), 1e-10);
}

/// One coupling against the closed form of implicit Euler for a mass on a damped spring, free tet, all points
/// alike.
TEST(Coupling, StepMatchesImplicitEulerOfADampedOscillator) {
  const Bodies bodies = single_body(unit_tet_mesh(1.0));
  Dynamics dynamics = Scene{{1e5, 0.3, 24.0, 0.0, 0.0}, {}, 1}.dynamics(bodies);  // 1 kg a point
  constexpr double k = 30.0;
  constexpr double d = 0.7;
  constexpr double h = 0.05;
  double x = 0.0;
  double v = 1.5;
  dynamics.set_velocities(std::vector<Vec3>(4, {0.0, v, 0.0}));
  for (int i = 0; i < 30; ++i) {
    std::vector<Coupling> springs(4);
    for (Index p = 0; p < 4; ++p) {
      Coupling& c = at(springs, p);
      c.points[0] = p;
      c.coefficients[0] = 1.0;
      c.force = {0.0, -k * (at(dynamics.positions(), p).y - at(bodies.points_rest(), p).y), 0.0};
      c.stiffness.yy = k;
      c.damping.yy = d;
    }
    dynamics.step(h, {}, {}, springs, 1e-14, 100);
    v = (v - h * k * x) / (1.0 + h * d + h * h * k);
    x += h * v;
    EXPECT_NEAR(dynamics.velocities()[2].y, v, 1e-11);
    EXPECT_NEAR(dynamics.positions()[0].y, x, 1e-11);
  }
}

TEST(Coupling, ToAFixedPointDoesNotMoveIt) {
  const Bodies bodies = two_tets();
  std::vector<std::uint8_t> fixed(8, 0);
  std::fill(fixed.begin(), fixed.begin() + 4, 1);
  const Material undamped{1e5, 0.3, 1000.0, 0.0, 0.0};
  Dynamics dynamics = Scene{undamped, fixed, 1}.dynamics(bodies);
  const std::vector<Coupling> couplings{contact()};
  for (int i = 0; i < 10; ++i) dynamics.step(0.01, standard_gravity, {}, couplings, 1e-10, 200);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(dynamics.positions()[i], bodies.points_rest()[i]);
  EXPECT_NE(dynamics.positions()[4], bodies.points_rest()[4]);
}

}  // namespace
}  // namespace palpate::fem::test

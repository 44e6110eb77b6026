#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "support/meshes.hpp"

namespace palpate::fem::test {
namespace {

/// Largest difference between the edge lengths now and at rest, as a fraction of the length at rest.
double edge_strain(const Bodies& bodies, std::span<const Vec3> positions) {
  double most = 0.0;
  for (const Edge& e : bodies.edges()) {
    const double rest = length(at(bodies.points_rest(), e[1]) - at(bodies.points_rest(), e[0]));
    const double strain = std::abs(length(at(positions, e[1]) - at(positions, e[0])) / rest - 1.0);
    most = strain <= most ? most : strain;
  }
  return most;
}

double smallest_volume(const Bodies& bodies, std::span<const Vec3> positions) {
  double least = 1e300;
  for (const Tet& t : bodies.tets()) {
    const Vec3& a = at(positions, t[0]);
    least = std::min(least,
                     dot(at(positions, t[1]) - a, cross(at(positions, t[2]) - a, at(positions, t[3]) - a)));
  }
  return least;
}

TEST(Dynamics, RestStaysAtRestExactly) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 2}, {0.4, 0.3, 0.2}, 0.2));
  Dynamics dynamics = Scene{{1e4, 0.45, 1000.0, 0.1, 0.01}, {}, 1}.dynamics(bodies);
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(dynamics.step(0.01, {}, {}, {}, 1e-6, 100).converged);
  EXPECT_TRUE(std::ranges::equal(dynamics.positions(), bodies.points_rest()));
  EXPECT_EQ(largest(dynamics.velocities()), 0.0);
  EXPECT_EQ(dynamics.elastic_energy(), 0.0);
}

/// Implicit Euler under constant acceleration: v_n = g h n, x_n = x_0 + g h^2 n (n + 1) / 2.
TEST(Dynamics, FreeFallIsExactForAllPointsAlike) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 2}, {0.4, 0.3, 0.2}, 0.2));
  Dynamics dynamics = Scene{{1e5, 0.4, 1000.0, 0.0, 0.0}, {}, 1}.dynamics(bodies);
  constexpr double h = 0.01;
  for (int n = 1; n <= 100; ++n) {
    dynamics.step(h, standard_gravity, {}, {}, 1e-4, 500);  // exact at a loose tolerance too
    const auto expected =
        mapped(bodies, [&](const Vec3& p) { return p + (0.5 * n * (n + 1) * h * h) * standard_gravity; });
    ASSERT_LT(largest_distance(dynamics.positions(), expected), 1e-13 * n) << "step " << n;
  }
  EXPECT_NEAR(dynamics.velocities()[7].z, -9.81, 1e-12);
  EXPECT_NEAR(dynamics.kinetic_energy(), 0.5 * 24.0 * 9.81 * 9.81, 1e-9);
}

/// With mass damping: v_{n+1} = (v_n + h g) / (1 + h a).
TEST(Dynamics, MassDampingSlowsAFallAsImplicitEulerDoes) {
  const Bodies bodies = single_body(box_mesh({2, 2, 2}, {0.2, 0.2, 0.2}));
  Dynamics dynamics = Scene{{1e5, 0.4, 1000.0, 3.0, 0.02}, {}, 1}.dynamics(bodies);
  double v = 0.0;
  for (int n = 0; n < 50; ++n) {
    dynamics.step(0.02, standard_gravity, {}, {}, 1e-12, 500);
    v = (v - 0.02 * 9.81) / (1.0 + 0.02 * 3.0);
  }
  for (const Vec3& velocity : dynamics.velocities()) EXPECT_NEAR(velocity.z, v, 1e-12);
}

TEST(Dynamics, StepSolvesTheEquationThatItStates) {
  // One step against the dense formula, assembled here from forces and their differences at fixed rotations.
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {0.2, 0.2, 0.2}, 0.2));
  const Material material{3e4, 0.3, 1000.0, 2.0, 0.005};
  constexpr double h = 0.02;
  const auto fixed = select(bodies, [](const Vec3& p) { return p.z == 0.0; });
  Dynamics dynamics = Scene{material, fixed, 1}.dynamics(bodies);
  const auto start = noisy(bodies, 0.02, 41);
  dynamics.set_positions(start);
  dynamics.set_velocities(random_vectors(start.size(), 1.0, 42));
  const auto external = random_vectors(start.size(), 0.3, 43);
  const std::vector<Vec3> before(dynamics.velocities().begin(), dynamics.velocities().end());
  ASSERT_TRUE(dynamics.step(h, standard_gravity, external, {}, 1e-14, 1000).converged);

  Elements elements(bodies, std::vector<Material>(1, material), std::vector<std::uint8_t>(1, 0));
  elements.update(parallel::Threads(1), start);
  const auto n = 3 * static_cast<Eigen::Index>(start.size());
  const Eigen::MatrixXd k = dense_stiffness(elements, start.size());
  Eigen::VectorXd masses(n);
  for (Eigen::Index i = 0; i < n; ++i) masses[i] = at(dynamics.point_masses(), i / 3);
  const Eigen::MatrixXd m = masses.asDiagonal();
  const Eigen::MatrixXd c = material.mass_damping * m + material.stiffness_damping * k;
  // Stiffness damping leaves out the rotation with the same angular momentum.
  const Eigen::VectorXd rotation = to_eigen(rotation_of(dynamics.point_masses(), start, before));
  Eigen::VectorXd force = to_eigen(point_forces(elements)) + to_eigen(external);
  for (Eigen::Index i = 2; i < n; i += 3) force[i] += masses[i] * standard_gravity.z;
  Eigen::MatrixXd a = m + h * c + h * h * k;
  const Eigen::VectorXd v = to_eigen(before);
  Eigen::VectorXd b = h * (force - c * v + material.stiffness_damping * (k * rotation) - h * (k * v));
  for (Eigen::Index i = 0; i < n; ++i) {
    if (at(fixed, i / 3) == 0) continue;
    a.row(i).setZero();
    a.col(i).setZero();
    a(i, i) = 1.0;
    b[i] = 0.0;
  }
  const Eigen::VectorXd change = a.llt().solve(b);
  EXPECT_LT((to_eigen(dynamics.velocities()) - v - change).norm(), 1e-10 * change.norm());
  EXPECT_LT((to_eigen(dynamics.positions()) - to_eigen(start) - h * (v + change)).norm(), 1e-12);
}

TEST(Dynamics, FixedObstacleAndLonelyPointsNeverMove) {
  TetMesh mesh = box_mesh({3, 3, 3}, {0.3, 0.3, 0.3});
  mesh.points.push_back({1.0, 1.0, 1.0});
  Bodies bodies = single_body(mesh);
  bodies.add("plate", box_mesh({1, 1, 1}, {1.0, 1.0, 0.1}));
  const auto fixed = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  Dynamics dynamics(bodies, std::vector<Material>(2, {1e4, 0.4, 1000.0, 0.0, 0.0}), fixed,
                    std::vector<std::uint8_t>{0, 1}, parallel::Threads(1));
  dynamics.set_velocities(random_vectors(fixed.size(), 1.0, 44));
  const std::vector<Vec3> pull(fixed.size(), {1.0, 2.0, 3.0});
  for (int i = 0; i < 30; ++i) dynamics.step(0.01, standard_gravity, pull, {}, 1e-8, 200);
  const Index lonely = 64;
  ASSERT_EQ(dynamics.point_masses()[64], 0.0);
  for (Index i = 0; i < static_cast<Index>(fixed.size()); ++i) {
    if (at(fixed, i) == 0 && i < lonely) {
      EXPECT_NE(at(dynamics.positions(), i), at(bodies.points_rest(), i));
      continue;
    }
    EXPECT_EQ(at(dynamics.positions(), i), at(bodies.points_rest(), i));
    EXPECT_EQ(at(dynamics.velocities(), i), Vec3{});
  }
}

TEST(Dynamics, ConservesMomentumWithoutExternalForces) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2));
  Dynamics dynamics = Scene{{2e4, 0.4, 1000.0, 0.0, 0.01}, {}, 1}.dynamics(bodies);
  dynamics.set_positions(noisy(bodies, 0.03, 45));
  dynamics.set_velocities(random_vectors(bodies.points_rest().size(), 1.0, 46));
  const Vec3 before = momentum(dynamics);
  ASSERT_GT(length(before), 0.1);
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(dynamics.step(0.01, {}, {}, {}, 1e-13, 2000).converged);
  EXPECT_LT(length(momentum(dynamics) - before), 1e-11 * length(before));
}

TEST(Dynamics, EnergyOfADampedIsolatedBodyDoesNotGrow) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2));
  Dynamics dynamics = Scene{{2e4, 0.4, 1000.0, 0.5, 0.005}, {}, 1}.dynamics(bodies);
  std::mt19937_64 random(47);
  const Matrix3 r = random_rotation(random);
  dynamics.set_positions(mapped(bodies, [&](const Vec3& p) {
    return r * Vec3{1.3 * p.x + 0.3 * p.y, 0.8 * p.y, p.z + 0.5 * p.x * p.y};
  }));
  dynamics.set_velocities(random_vectors(bodies.points_rest().size(), 0.3, 48));
  double energy = dynamics.elastic_energy() + dynamics.kinetic_energy();
  const double first = energy;
  for (int i = 0; i < 300; ++i) {
    dynamics.step(0.01, {}, {}, {}, 1e-8, 2000);
    const double next = dynamics.elastic_energy() + dynamics.kinetic_energy();
    EXPECT_LE(next, energy * (1.0 + 1e-9)) << "step " << i;
    energy = next;
  }
  EXPECT_LT(dynamics.elastic_energy(), 1e-3 * first);
}

/// Undamped small vibration keeps, per step, the factor 1 / sqrt(1 + h^2 w^2) of implicit Euler, which for h
/// -> 0 is 1.
TEST(Dynamics, SmallTimeStepsNearlyConserveEnergy) {
  const Bodies bodies = single_body(unit_tet_mesh(0.1));
  Dynamics dynamics = Scene{{1e4, 0.3, 1000.0, 0.0, 0.0}, {}, 1}.dynamics(bodies);
  dynamics.set_positions(mapped(bodies, [](const Vec3& p) { return Vec3{1.05 * p.x, p.y, p.z}; }));
  const double first = dynamics.elastic_energy();
  for (int i = 0; i < 2000; ++i) dynamics.step(1e-6, {}, {}, {}, 1e-12, 200);
  const double last = dynamics.elastic_energy() + dynamics.kinetic_energy();
  EXPECT_GT(dynamics.kinetic_energy(), 0.01 * first);
  EXPECT_NEAR(last / first, 1.0, 0.02);
}

void expect_recovery(const Bodies& bodies, const std::vector<Vec3>& start, const char* what) {
  Dynamics dynamics = Scene{{2e4, 0.4, 1000.0, 1.0, 0.01}, {}, 1}.dynamics(bodies);
  dynamics.set_positions(start);
  for (int i = 0; i < 600; ++i) {
    dynamics.step(0.01, {}, {}, {}, 1e-8, 2000);
    ASSERT_TRUE(std::isfinite(largest(dynamics.positions()))) << what << ", step " << i;
  }
  EXPECT_LT(edge_strain(bodies, dynamics.positions()), 1e-3) << what;
  EXPECT_GT(smallest_volume(bodies, dynamics.positions()), 0.0) << what;
}

TEST(Dynamics, InvertedFlatAndCollapsedElementsRecoverToRest) {
  const Bodies tet = single_body(unit_tet_mesh(0.1));
  expect_recovery(tet, mapped(tet, [](const Vec3& p) { return Vec3{p.x, p.y, -p.z}; }), "mirrored tet");
  expect_recovery(tet,
                  mapped(tet,
                         [](const Vec3& p) {
                           return Vec3{p.x + 0.1 * p.z, p.y, -0.7 * p.z};
                         }),
                  "inverted tet");
  expect_recovery(tet, mapped(tet, [](const Vec3& p) { return Vec3{p.x, p.y, 0.0}; }), "flat tet");
  expect_recovery(tet,
                  mapped(tet,
                         [](const Vec3& p) {
                           return Vec3{p.x + p.y + p.z, 0.0, 0.0};
                         }),
                  "tet on a line");
  expect_recovery(tet, mapped(tet, [](const Vec3&) { return Vec3{1.0, 2.0, 3.0}; }), "tet in a point");

  const Bodies box = single_body(box_mesh({3, 3, 3}, {0.3, 0.3, 0.3}));
  auto pushed = mapped(box, [](const Vec3& p) { return p; });
  pushed[21] += Vec3{0.17, 0.15, 0.12};  // an inner point through its neighbours
  ASSERT_LT(smallest_volume(box, pushed), 0.0);
  expect_recovery(box, pushed, "box with inverted tets");
  expect_recovery(box, mapped(box, [](const Vec3& p) { return Vec3{p.x, p.y, 0.0}; }), "flat box");
  expect_recovery(box, mapped(box, [](const Vec3&) { return Vec3{}; }), "box in a point");
}

TEST(Dynamics, ACollapsedOrInvertedBallRecovers) {
  const Bodies ball = single_body(palpate::test::ball_mesh(3, {0.0, 0.0, 0.0}, 0.15));
  expect_recovery(ball, mapped(ball, [](const Vec3&) { return Vec3{1.0, 2.0, 3.0}; }), "ball in a point");
  expect_recovery(ball, mapped(ball, [](const Vec3& p) { return 1e-12 * p; }), "ball nearly in a point");
  expect_recovery(ball, mapped(ball, [](const Vec3& p) { return Vec3{0.0, 0.0, p.z}; }), "ball on a line");
  expect_recovery(ball, mapped(ball, [](const Vec3& p) { return Vec3{p.x, p.y, 0.0}; }), "flat ball");
  expect_recovery(ball, mapped(ball, [](const Vec3& p) { return Vec3{p.x, p.y, -p.z}; }), "mirrored ball");
  expect_recovery(ball, mapped(ball, [](const Vec3& p) { return -p; }), "ball inside out");
  expect_recovery(ball, random_vectors(ball.points_rest().size(), 0.1, 51), "points anywhere");
}

TEST(Dynamics, KeepsEachBodysOwnMaterial) {
  // Two equal boxes hang from fixed tops; ten times the stiffness gives a tenth of the sag.
  Bodies bodies;
  bodies.add("soft", box_mesh({2, 2, 2}, {0.1, 0.1, 0.1}));
  bodies.add("hard", box_mesh({2, 2, 2}, {0.1, 0.1, 0.1}));
  const auto fixed = select(bodies, [](const Vec3& p) { return p.z == 0.1; });
  std::vector<Material> materials(2, {1e6, 0.3, 1000.0, 0.0, 0.0});
  materials[1].young_modulus = 1e7;
  Dynamics dynamics(bodies, materials, fixed, std::vector<std::uint8_t>(2, 0), parallel::Threads(1));
  std::vector<Vec3> weight;
  for (const double mass : dynamics.point_masses()) weight.push_back(mass * standard_gravity);
  settle(dynamics, weight, 3);
  const double soft_sag = -dynamics.positions()[4].z;
  const double hard_sag = -dynamics.positions()[27 + 4].z;
  EXPECT_NEAR(soft_sag / hard_sag, 10.0, 0.01);
  EXPECT_GT(soft_sag, 1e-5);
}

TEST(Dynamics, GivesTheSameBitsForEveryThreadCount) {
  const Bodies bodies = single_body(irregular_box_mesh({14, 14, 14}, {0.5, 0.5, 0.5}, 0.2));
  const auto run = [&](int threads) {
    const auto fixed = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
    const Material soft{2e4, 0.4, 1000.0, 0.0, 0.001};
    Dynamics dynamics = Scene{soft, fixed, threads}.dynamics(bodies);
    dynamics.set_positions(noisy(bodies, 0.01, 50));
    std::vector<Coupling> couplings(700);
    for (Index c = 0; c < 700; ++c) {
      at(couplings, c).points = {3 * c, 3 * c + 1, 3 * c + 2, 3 * c + 50, -1};
      at(couplings, c).coefficients = {1.0, -0.3, -0.3, -0.4, 0.0};
      at(couplings, c).force = {0.1, 0.2, 0.3};
      at(couplings, c).stiffness = {30.0, 20.0, 10.0, 1.0, 2.0, 3.0};
      at(couplings, c).damping = {0.3, 0.2, 0.1, 0.0, 0.0, 0.0};
    }
    for (int i = 0; i < 4; ++i) dynamics.step(0.01, standard_gravity, {}, couplings, 1e-5, 60);
    std::vector<Vec3> state(dynamics.positions().begin(), dynamics.positions().end());
    state.insert(state.end(), dynamics.velocities().begin(), dynamics.velocities().end());
    state.push_back({dynamics.kinetic_energy(), dynamics.elastic_energy(), 0.0});
    return state;
  };
  const auto expected = run(1);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(run(threads), expected) << threads;
}

}  // namespace
}  // namespace palpate::fem::test

// Freely rotating bodies. Oracles: conservation of momentum and energy, a rotation by omega t, and Euler's
// equations of the rigid body integrated by small steps of another method (Runge-Kutta) with Eigen.
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr double density = 1000.0;

/// A stiff box that rotates freely about its centre of mass.
struct SpinningBox {
  SpinningBox(const Vec3& size, const Vec3& angular_velocity, double young_modulus, int threads = 1)
      : SpinningBox(size, angular_velocity, Material{young_modulus, 0.4, density, 0.0, 0.001}, threads) {}
  SpinningBox(const Vec3& size, const Vec3& angular_velocity, const Material& material, int threads = 1)
      : bodies(single_body(box_mesh({3, 3, 3}, size))),
        dynamics(Scene{material, {}, threads}.dynamics(bodies)) {
    const Eigen::Vector3d c = center();
    std::vector<Vec3> velocities;
    for (const Vec3& p : bodies.points_rest()) {
      const Eigen::Vector3d v = to_eigen(angular_velocity).cross(to_eigen(p) - c);
      velocities.push_back({v.x(), v.y(), v.z()});
    }
    dynamics.set_velocities(velocities);
  }

  void step(double h) { dynamics.step(h, {}, {}, {}, 1e-9, 2000); }

  [[nodiscard]] Eigen::Vector3d center() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double mass = 0.0;
    for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
      mass += dynamics.point_masses()[i];
      sum += dynamics.point_masses()[i] * to_eigen(dynamics.positions()[i]);
    }
    return sum / mass;
  }
  [[nodiscard]] Eigen::Vector3d angular_momentum() const {
    const Eigen::Vector3d c = center();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
      sum += dynamics.point_masses()[i] *
             (to_eigen(dynamics.positions()[i]) - c).cross(to_eigen(dynamics.velocities()[i]));
    }
    return sum;
  }
  [[nodiscard]] Eigen::Matrix3d inertia_rest() const {
    const Eigen::Vector3d c = center();
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
      const Eigen::Vector3d a = to_eigen(bodies.points_rest()[i]) - c;
      sum += dynamics.point_masses()[i] * (a.squaredNorm() * Eigen::Matrix3d::Identity() - a * a.transpose());
    }
    return sum;
  }
  /// Rotation of the best rigid fit to the rest shape (Kabsch).
  [[nodiscard]] Eigen::Matrix3d rotation() const {
    const Eigen::Vector3d c = center();
    const Eigen::Vector3d c_rest = c;  // it rotates about a centre at rest
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < dynamics.positions().size(); ++i) {
      sum +=
          (to_eigen(dynamics.positions()[i]) - c) * (to_eigen(bodies.points_rest()[i]) - c_rest).transpose();
    }
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
    return svd.matrixU() * svd.matrixV().transpose();
  }
  [[nodiscard]] double largest_strain() const { return largest_strain_at(dynamics.positions()); }
  [[nodiscard]] double largest_strain_at(std::span<const Vec3> positions) const {
    double most = 0.0;
    for (const Edge& e : bodies.edges()) {
      const double rest = length(at(bodies.points_rest(), e[1]) - at(bodies.points_rest(), e[0]));
      const double now = length(at(positions, e[1]) - at(positions, e[0]));
      most = std::max(most, std::abs(now / rest - 1.0));
    }
    return most;
  }

  Bodies bodies;
  Dynamics dynamics;
};

/// h omega = 0.2: straight paths would swell the box by 2 % in each step.
TEST(BodyRotations, AStiffCubeSpinsOnWithoutLossAndKeepsItsSize) {
  constexpr double h = 0.02;
  const Vec3 angular_velocity{6.0, -8.0, 0.0};
  SpinningBox box({0.04, 0.04, 0.04}, angular_velocity, 2e7);
  const Eigen::Vector3d momentum = box.angular_momentum();
  const double energy = box.dynamics.kinetic_energy();
  for (int n = 1; n <= 200; ++n) {
    box.step(h);
    ASSERT_LT((box.angular_momentum() - momentum).norm(), 1e-6 * momentum.norm()) << n;
    ASSERT_NEAR(box.dynamics.kinetic_energy() + box.dynamics.elastic_energy(), energy, 1e-6 * energy) << n;
    ASSERT_LT(box.largest_strain(), 1e-5) << n;
  }
  const Eigen::Vector3d axis = to_eigen(angular_velocity).normalized();
  const Eigen::Matrix3d expected = Eigen::AngleAxisd(10.0 * 200 * h, axis).toRotationMatrix();
  EXPECT_LT((box.rotation() - expected).norm(), 1e-4);
}

/// A box of three unlike edges tumbles: its axis wanders while the angular momentum stays.
TEST(BodyRotations, ABoxTumblesAsARigidBodyWithoutTorque) {
  constexpr double h = 0.005;
  const Vec3 angular_velocity{1.0, 8.0, 1.0};  // near the middle axis, which is not stable
  SpinningBox box({0.03, 0.04, 0.06}, angular_velocity, 2e8);
  const Eigen::Vector3d momentum = box.angular_momentum();
  const Eigen::Matrix3d inverse = box.inertia_rest().inverse();
  const double energy = box.dynamics.kinetic_energy();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  const auto rate = [&](const Eigen::Quaterniond& at) {
    const Eigen::Matrix3d r = at.normalized().toRotationMatrix();
    const Eigen::Vector3d w = r * inverse * r.transpose() * momentum;
    return Eigen::Vector4d((Eigen::Quaterniond(0.0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()) * at).coeffs());
  };
  const auto ahead = [&](const Eigen::Vector4d& k, double s) {
    return Eigen::Quaterniond(Eigen::Vector4d(q.coeffs() + s * k));
  };
  double turned = 0.0;
  for (int n = 1; n <= 200; ++n) {
    box.step(h);
    constexpr int parts = 20;
    constexpr double s = h / parts;
    for (int i = 0; i < parts; ++i) {
      const Eigen::Vector4d k1 = rate(q);
      const Eigen::Vector4d k2 = rate(ahead(k1, 0.5 * s));
      const Eigen::Vector4d k3 = rate(ahead(k2, 0.5 * s));
      const Eigen::Vector4d k4 = rate(ahead(k3, s));
      q = ahead(k1 + 2.0 * k2 + 2.0 * k3 + k4, s / 6.0).normalized();
    }
    ASSERT_LT((box.angular_momentum() - momentum).norm(), 1e-5 * momentum.norm()) << n;
    ASSERT_NEAR(box.dynamics.kinetic_energy() + box.dynamics.elastic_energy(), energy, 2e-3 * energy) << n;
    ASSERT_LT((box.rotation() - q.toRotationMatrix()).norm(), 0.02) << n;
    turned = std::max(turned, (q.toRotationMatrix() - Eigen::Matrix3d::Identity()).norm());
  }
  EXPECT_GT(turned, 2.0);
}

/// A needle rotates end over end, by 0.3, 0.6 and 2 radians in a step. The smallest tilt of its axis is a
/// fast rotation about this axis, since its inertia about it is 450 times smaller.
TEST(BodyRotations, ANeedleRotatesEndOverEndWithoutGain) {
  constexpr double h = 0.01;
  for (const double rate : {30.0, 60.0, 200.0}) {
    SpinningBox box({0.06, 0.002, 0.002}, {0.0, 0.0, rate}, 1e7);
    const Eigen::Vector3d momentum = box.angular_momentum();
    const double energy = box.dynamics.kinetic_energy();
    for (int n = 1; n <= 100; ++n) {
      box.step(h);
      ASSERT_LT((box.angular_momentum() - momentum).norm(), 1e-2 * momentum.norm()) << rate << ", " << n;
      ASSERT_NEAR(box.dynamics.kinetic_energy() + box.dynamics.elastic_energy(), energy, 0.05 * energy)
          << rate << ", " << n;
    }
    // It has stayed in its plane.
    EXPECT_GT(std::abs(box.rotation()(2, 2)), 0.99) << rate;
  }
}

/// A couple rotates a cube from rest in one step, by 4 or 17 degrees, by forces that accelerate its points
/// like a rigid body. Straight paths would swell it by half the square of the angle. The first is bent, the
/// second gets a frame. Without a frame the momentum is the couple times the step.
TEST(BodyRotations, ABodyRotatedByACoupleKeepsItsSizeAndHasTheMomentumOfTheCouple) {
  constexpr double h = 0.01;
  for (const double angle : {0.07, 0.3}) {
    SpinningBox box({0.04, 0.04, 0.04}, {}, 2e7);
    const Eigen::Vector3d c = box.center();
    const Eigen::Vector3d acceleration = angle / (h * h) * Eigen::Vector3d(0.48, 0.6, 0.64);
    std::vector<Vec3> forces;
    for (std::size_t i = 0; i < box.dynamics.positions().size(); ++i) {
      const Eigen::Vector3d f =
          box.dynamics.point_masses()[i] * acceleration.cross(to_eigen(box.dynamics.positions()[i]) - c);
      forces.push_back({f.x(), f.y(), f.z()});
    }
    const Eigen::Vector3d expected = h * box.inertia_rest() * acceleration;
    box.dynamics.step(h, {}, forces, {}, 1e-9, 2000);
    EXPECT_LT(box.largest_strain(), 0.01 * 0.5 * angle * angle) << angle;
    const bool bent = angle < 0.08;
    EXPECT_LT((box.angular_momentum() - expected).norm(), (bent ? 1e-6 : 0.05) * expected.norm()) << angle;
    const Eigen::AngleAxisd rotation(box.rotation());
    EXPECT_NEAR(rotation.angle(), angle, (bent ? 1e-4 : 0.05) * angle);
    const double energy = 0.5 * expected.squaredNorm() / box.inertia_rest()(0, 0);
    EXPECT_NEAR(box.dynamics.kinetic_energy(), energy, (bent ? 1e-5 : 0.1) * energy) << angle;
  }
}

/// Contacts rotate a cube from rest, by more than arcs allow. The solution and the search directions turn
/// with the frame. Oracle: the same solves with new directions, since the system has a coupling (without
/// stiffness).
TEST(BodyRotations, ASolutionAndItsDirectionsTurnWithTheFrame) {
  constexpr double h = 0.01;
  constexpr double size = 0.04;
  int iterations = 0;
  std::vector<Vec3> expected;
  for (const bool turns : {false, true}) {
    SpinningBox box({size, size, size}, {}, 2e7);
    std::vector<ContactLaw> laws;
    std::vector<Coupling> couplings(turns ? 0 : 1);
    if (!turns) couplings.front().points = {0, -1, -1, -1, -1};
    const std::size_t first = couplings.size();
    for (Index i = 0; i < std::ssize(box.bodies.points_rest()); ++i) {
      const Vec3& p = at(box.bodies.points_rest(), i);
      if ((p.x != 0.0 && p.x != size) || p.x != p.z) continue;
      laws.push_back({.stiffness = 300.0, .depth = 0.01, .direction = {0.0, 0.0, p.x == 0.0 ? 1.0 : -1.0}});
      couplings.emplace_back().points = {i, -1, -1, -1, -1};
      couplings.back().coefficients = {1.0, 0.0, 0.0, 0.0, 0.0};
    }
    const auto solve = [&] {
      const SolveReport report = box.dynamics.solve({.laws = laws,
                                                     .couplings = couplings,
                                                     .first = first,
                                                     .friction = {.coefficient = 0.0, .time_step = h}},
                                                    {.tolerance = 1e-4,
                                                     .max_iterations = 1000,
                                                     .of_solution = true,
                                                     .preconditioner = Preconditioner::jacobi},
                                                    false);
      EXPECT_TRUE(report.converged);
      return report.iterations;
    };
    box.dynamics.begin_step(h, {}, {});
    solve();
    ASSERT_TRUE(box.dynamics.update_rotating_frames());
    EXPECT_LT(box.largest_strain_at(box.dynamics.end_positions()), 0.005);
    const int again = solve();
    if (turns) {
      EXPECT_LT(again, iterations);
      EXPECT_LT(largest_distance(box.dynamics.mean_velocities(), expected), 1e-4 * largest(expected));
    }
    iterations = again;
    expected.assign(box.dynamics.mean_velocities().begin(), box.dynamics.mean_velocities().end());
    EXPECT_FALSE(box.dynamics.update_rotating_frames());
    box.dynamics.end_step();
    EXPECT_GT(Eigen::AngleAxisd(box.rotation()).angle(), 0.15);
    EXPECT_LT(box.largest_strain(), 0.005);
  }
}

/// A step at fixed axes takes the square of the angle from the energy of a hyperelastic body: after 1 s, 0.5
/// to 10 ms at a time, it had lost up to 80 % of its energy.
TEST(BodyRotations, AHyperelasticBodySpinsOnInStepsOfAnyLength) {
  for (const MaterialModel model : {MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    for (const double h : {0.0005, 0.001, 0.002, 0.005, 0.02}) {
      SpinningBox box(
          {0.2, 0.04, 0.04}, {0.0, 0.0, 20.0},
          Material{.young_modulus = 1e6, .poisson_ratio = 0.3, .density = density, .model = model});
      const Eigen::Vector3d momentum = box.angular_momentum();
      const double energy = box.dynamics.kinetic_energy();
      for (double t = 0.0; t < 0.5; t += h) box.step(h);
      EXPECT_LT((box.angular_momentum() - momentum).norm(), 3e-3 * momentum.norm()) << h;
      const double end = box.dynamics.kinetic_energy() + box.dynamics.elastic_energy();
      EXPECT_LT(end, 1.001 * energy) << h;
      EXPECT_GT(end, 0.99 * energy) << h;
    }
  }
}

/// The centrifugal force stretches the body by a fifth. A frame that turned the velocity of this deformation
/// with the body, without Coriolis force, added up to 41 % to the energy.
TEST(BodyRotations, ABodyThatItsSpinStretchesGainsNoEnergy) {
  for (const MaterialModel model : {MaterialModel::corotational, MaterialModel::mooney_rivlin}) {
    for (const double h : {0.001, 0.005, 0.02}) {
      SpinningBox box(
          {0.2, 0.04, 0.04}, {0.0, 0.0, 12.0},
          Material{.young_modulus = 5e3, .poisson_ratio = 0.3, .density = density, .model = model});
      const Eigen::Vector3d momentum = box.angular_momentum();
      const double energy = box.dynamics.kinetic_energy();
      double most = 0.0;
      double stretch = 0.0;
      for (double t = 0.0; t < 1.0; t += h) {
        box.step(h);
        most = std::max(most, box.dynamics.kinetic_energy() + box.dynamics.elastic_energy());
        stretch = std::max(stretch, box.largest_strain());
      }
      EXPECT_LT((box.angular_momentum() - momentum).norm(), 0.05 * momentum.norm()) << h;
      EXPECT_LT(most, (1.005 + 2.5 * h) * energy) << h;
      EXPECT_GT(stretch, 0.15) << h;
    }
  }
}

/// The centrifugal force stretches a soft body, which a frame would suppress: it gets no frame.
TEST(BodyRotations, ASoftBodyIsNotFollowed) {
  SpinningBox box({0.04, 0.04, 0.04}, {0.0, 0.0, 5.0}, 1e3);
  box.step(0.005);
  EXPECT_FALSE(box.dynamics.update_rotating_frames());
  for (int n = 0; n < 200; ++n) box.step(0.005);
  EXPECT_GT(box.largest_strain(), 1e-3);
}

}  // namespace
}  // namespace palpate::fem::test

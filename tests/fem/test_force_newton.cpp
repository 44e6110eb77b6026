// A few contacts whose velocities depend linearly on their forces. Oracles: the forces of the laws at the
// velocities that belong to the result; all sets of closed contacts, without friction; Coulomb's law written
// out for a block that is pushed on a plane.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "fem/force_newton.hpp"
#include "support/random.hpp"

namespace palpate::fem::test {
namespace {

ContactLaw any_law(palpate::test::Random& random) {
  const Vec3 direction = normalized(random.point(-1, 1));
  const Vec3 slip = random.point(-1e-3, 1e-3);
  return {.stiffness = std::pow(10.0, random.uniform(0.0, 6.0)),
          .damping = random.uniform(0.0, 10.0),
          .depth = random.uniform(-1e-3, 1e-2),
          .slip = slip - dot(slip, direction) * direction,
          .direction = direction};
}

/// Random contacts of bodies with `size` degrees of freedom.
struct RandomContacts {
  std::vector<ContactLaw> laws;
  std::vector<Vec3> free;
  std::vector<double> rows;
  CondensedContacts problem;

  RandomContacts(palpate::test::Random& random, int count, int size, double friction) {
    const double h = std::pow(10.0, random.uniform(-3.0, -1.7));
    for (int k = 0; k < count; ++k) {
      laws.push_back(any_law(random));
      free.push_back(random.point(-0.5, 0.5));
      for (int i = 0; i < 3 * size; ++i) rows.push_back(random.uniform(-1.0, 1.0));
    }
    problem = {.laws = laws,
               .friction = {.coefficient = friction, .time_step = h},
               .free = free,
               .rows = rows,
               .size = static_cast<std::size_t>(size)};
  }
  RandomContacts(const RandomContacts&) = delete;
  RandomContacts& operator=(const RandomContacts&) = delete;

  [[nodiscard]] Vec3 column(std::size_t contact, std::size_t i) const {
    const double* row = &rows[3 * problem.size * contact];
    return {row[i], row[problem.size + i], row[2 * problem.size + i]};
  }
  /// Relative velocity of a contact with these forces.
  [[nodiscard]] Vec3 velocity(std::size_t contact, const std::vector<Vec3>& forces) const {
    Vec3 u = free[contact];
    for (std::size_t i = 0; i < problem.size; ++i) {
      double y = 0.0;
      for (std::size_t k = 0; k < forces.size(); ++k)
        y += problem.friction.time_step * dot(column(k, i), forces[k]);
      u += y * column(contact, i);
    }
    return u;
  }
};

/// Largest difference of a force from that of its law, relative to the change of force by R times the largest
/// velocity: what the rounding of velocities can make.
double law_error(const RandomContacts& contacts, const std::vector<Vec3>& forces) {
  double error = 0.0;
  for (std::size_t k = 0; k < forces.size(); ++k) {
    const ContactLaw& law = contacts.laws[k];
    const Vec3 u = contacts.velocity(k, forces);
    const Vec3 of_law = contact_force(law, contacts.problem.friction, u).whole(law.direction);
    const double unit = law.resistance(contacts.problem.friction.time_step) + length(forces[k]);
    error = std::max(error, length(of_law - forces[k]) / unit);
  }
  return error;
}

TEST(ForceNewton, ForcesAreThoseOfTheLawsAtTheirVelocities) {
  palpate::test::Random random(1);
  int open = 0;
  int stuck = 0;
  int sliding = 0;
  int solved = 0;
  ForceNewton newton;
  constexpr int cases = 3000;
  for (int i = 0; i < cases; ++i) {
    const int count = random.integer(1, 30);
    const double friction = random.chance(0.1) ? 0.0 : random.uniform(0.0, 0.5);
    // With few degrees of freedom, contacts depend on each other.
    const RandomContacts contacts(random, count, random.integer(3, 40), friction);
    std::vector<Vec3> forces(contacts.laws.size());
    for (Vec3& f : forces) f = random.point(-1, 1);
    if (!newton.solve(contacts.problem, forces)) continue;
    ++solved;
    EXPECT_LE(law_error(contacts, forces), 1e-7) << i;
    for (std::size_t k = 0; k < forces.size(); ++k) {
      const double normal = dot(forces[k], contacts.laws[k].direction);
      const double across = length(forces[k] - normal * contacts.laws[k].direction);
      (normal < 1e-9 ? open : across < 0.999 * friction * normal ? stuck : sliding) += 1;
    }
  }
  std::printf("%d of %d solved; %d open, %d stuck, %d sliding\n", solved, cases, open, stuck, sliding);
  EXPECT_GT(solved, cases * 99 / 100);
  EXPECT_GT(open, 1000);
  EXPECT_GT(stuck, 1000);
  EXPECT_GT(sliding, 1000);
}

/// Without friction the forces are unique, and one of the 2^n sets of closed contacts has them.
TEST(ForceNewton, WithoutFrictionForcesAreThoseOfTheOnlyFittingSet) {
  palpate::test::Random random(2);
  ForceNewton newton;
  int solved = 0;
  constexpr int cases = 200;
  for (int i = 0; i < cases; ++i) {
    const int count = random.integer(1, 7);
    const RandomContacts contacts(random, count, random.integer(2, 12), 0.0);
    std::vector<Vec3> forces(contacts.laws.size());
    if (!newton.solve(contacts.problem, forces)) continue;
    ++solved;
    const double h = contacts.problem.friction.time_step;
    Eigen::MatrixXd response(count, count);
    Eigen::VectorXd start(count);
    for (int k = 0; k < count; ++k) {
      const ContactLaw& law = at(contacts.laws, k);
      const double resistance = law.resistance(h);
      start[k] = dot(law.direction, at(contacts.free, k)) - law.stiffness * law.depth / resistance;
      for (int l = 0; l < count; ++l) {
        response(k, l) = k == l ? 1.0 / resistance : 0.0;
        for (std::size_t d = 0; d < contacts.problem.size; ++d)
          response(k, l) +=
              h * dot(law.direction, contacts.column(static_cast<std::size_t>(k), d)) *
              dot(at(contacts.laws, l).direction, contacts.column(static_cast<std::size_t>(l), d));
      }
    }
    bool found = false;
    for (int set = 0; set < (1 << count) && !found; ++set) {
      Eigen::MatrixXd m = response;
      Eigen::VectorXd b = -start;
      for (int k = 0; k < count; ++k) {
        if ((set >> k & 1) != 0) continue;
        m.row(k).setZero();
        m(k, k) = 1.0;
        b[k] = 0.0;
      }
      const Eigen::VectorXd f = m.fullPivLu().solve(b);
      const Eigen::VectorXd v = start + response * f;
      found = f.minCoeff() >= 0.0 && v.minCoeff() >= -1e-9;
      if (!found) continue;
      for (int k = 0; k < count; ++k)
        EXPECT_NEAR(dot(at(forces, k), at(contacts.laws, k).direction), f[k], 1e-6 * (1.0 + f.maxCoeff()))
            << i;
    }
    EXPECT_TRUE(found) << i;
  }
  EXPECT_GT(solved, cases * 98 / 100);
}

TEST(ForceNewton, ABlockOnAPlaneSlidesAgainstTheMotion) {
  // m dv = h f + h F with the push F = (30, 40, -100) N, at rest before.
  constexpr double h = 0.01;
  constexpr double mass = 1.0;
  const std::vector<ContactLaw> laws{{.stiffness = 4.0 * mass / (h * h), .direction = {0, 0, 1}}};
  const std::vector<Vec3> free{(h / mass) * Vec3{30.0, 40.0, -100.0}};
  const double r = 1.0 / std::sqrt(mass);
  const std::vector<double> rows{r, 0, 0, 0, r, 0, 0, 0, r};
  std::vector<Vec3> forces(1);
  const CondensedContacts problem{
      .laws = laws, .friction = {.coefficient = 0.2, .time_step = h}, .free = free, .rows = rows, .size = 3};
  EXPECT_TRUE(ForceNewton().solve(problem, forces));
  const double normal = forces[0].z;
  EXPECT_NEAR(normal, 80.0, 1e-9);  // R u = 4 m / h u: four fifths of the push
  EXPECT_NEAR(forces[0].x, -0.2 * normal * 0.6, 1e-9);
  EXPECT_NEAR(forces[0].y, -0.2 * normal * 0.8, 1e-9);
}

TEST(ContactLaw, PotentialHasTheForceAsItsDerivative) {
  palpate::test::Random random(3);
  constexpr double h = 0.01;
  for (int i = 0; i < 1000; ++i) {
    const ContactLaw law = any_law(random);
    const StepFriction step{.coefficient = random.uniform(0.0, 1.0), .time_step = h};
    const Vec3 u = random.point(-0.5, 0.5);
    const ContactForce force = contact_force(law, step, u);
    const double bound = step.coefficient * force.normal;
    const Vec3 along = normalized(random.point(-1, 1));
    constexpr double d = 1e-6;
    const double slope =
        (contact_potential(law, h, bound, u + d * along) - contact_potential(law, h, bound, u - d * along)) /
        (2.0 * d);
    const double size = length(force.whole(law.direction)) + law.resistance(h) * 1e-3;
    EXPECT_NEAR(-slope, dot(force.whole(law.direction), along), 1e-2 * size) << i;
  }
}

}  // namespace
}  // namespace palpate::fem::test

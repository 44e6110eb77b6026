// One contact whose velocity depends linearly on its force. Oracles: the force of the law at the velocity
// that belongs to the result; Coulomb's law written out for a block that is pushed on a plane.
#include <cmath>
#include <gtest/gtest.h>

#include "fem/single_contact.hpp"
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

/// A symmetric positive definite matrix with eigenvalues that differ by up to about `ratio` squared.
Matrix3 random_response(palpate::test::Random& random, double ratio) {
  Matrix3 a;
  for (int k = 0; k < 3; ++k) {
    const Vec3 x = random.point(-1, 1);
    add_outer(a, std::pow(ratio, random.uniform(-1.0, 1.0)), x, x);
  }
  return a;
}

/// |force of the law at the velocity of f - f| / |f|.
double law_error(const ContactLaw& law, const StepFriction& step, const Matrix3& response, const Vec3& free,
                 const Vec3& f) {
  const ContactForce of_law = contact_force(law, step, free + response * f);
  return length(of_law.whole(law.direction) - f) / std::max(length(f), 1e-12);
}

TEST(SingleContact, IsOpenSticksOrSlidesByItsLaw) {
  palpate::test::Random random(1);
  int open = 0;
  int stuck = 0;
  int sliding = 0;
  for (int i = 0; i < 20000; ++i) {
    const StepFriction step{.coefficient = random.chance(0.1) ? 0.0 : random.uniform(0.0, 0.5),
                            .time_step = std::pow(10.0, random.uniform(-3.0, -1.7))};
    const ContactLaw law = any_law(random);
    const Matrix3 response = random_response(random, 2.0);
    const Vec3 free = random.point(-0.5, 0.5);
    const Vec3 f = single_contact_force(law, step, response, free, random.point(-1, 1));
    if (length(f) == 0.0) {
      EXPECT_EQ(contact_force(law, step, free).normal, 0.0) << i;
      ++open;
      continue;
    }
    // The pull of a stiff spring is a small difference of large numbers.
    const double stiff = law.resistance(step.time_step) * std::sqrt(inner(response, response));
    EXPECT_LE(law_error(law, step, response, free, f), 1e-11 * (1.0 + stiff)) << i;
    const double normal = dot(f, law.direction);
    const double friction = length(f - normal * law.direction);
    (friction < 0.999 * step.coefficient * normal ? stuck : sliding) += 1;
  }
  EXPECT_GT(open, 1000);
  EXPECT_GT(stuck, 500);
  EXPECT_GT(sliding, 1000);
}

/// With responses of any kind there may be no force (Painleve). A force that is returned obeys the bound.
TEST(SingleContact, ObeysItsFrictionBoundWithAnyResponse) {
  palpate::test::Random random(2);
  int wrong = 0;
  constexpr int count = 20000;
  for (int i = 0; i < count; ++i) {
    const StepFriction step{.coefficient = random.uniform(0.0, 2.0), .time_step = 0.01};
    const ContactLaw law = any_law(random);
    const Matrix3 response = random_response(random, 1e3);
    const Vec3 free = random.point(-0.5, 0.5);
    const Vec3 f = single_contact_force(law, step, response, free, {});
    const double normal = dot(f, law.direction);
    ASSERT_GE(normal, 0.0) << i;
    ASSERT_LE(length(f - normal * law.direction), (1.0 + 1e-9) * step.coefficient * normal + 1e-300) << i;
    const double stiff = law.resistance(step.time_step) * std::sqrt(inner(response, response));
    if (length(f) > 0.0 && law_error(law, step, response, free, f) > 1e-11 * (1.0 + stiff)) ++wrong;
  }
  EXPECT_LT(wrong, count / 100);
}

TEST(SingleContact, ABlockOnAPlaneSlidesAgainstTheMotion) {
  // m dv = h f + h F with the push F = (3, 4, -100) N, at rest before.
  constexpr double h = 0.01;
  constexpr double mass = 1.0;
  const ContactLaw law{.stiffness = 4.0 * mass / (h * h), .direction = {0, 0, 1}};
  Matrix3 response;
  for (int k = 0; k < 3; ++k) response(k, k) = h / mass;
  const Vec3 free = (h / mass) * Vec3{30.0, 40.0, -100.0};
  const Vec3 f = single_contact_force(law, {.coefficient = 0.2, .time_step = h}, response, free, {});
  const double normal = f.z;
  EXPECT_NEAR(normal, 80.0, 1e-9);  // R u = 4 m / h u: four fifths of the push
  EXPECT_NEAR(f.x, -0.2 * normal * 0.6, 1e-9);
  EXPECT_NEAR(f.y, -0.2 * normal * 0.8, 1e-9);
}

TEST(SingleContact, PotentialHasTheForceAsItsDerivative) {
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

// Oracles: the update of Mueller & Gross 2004 by hand for one uniform strain, differences of the energy, and
// invariance under rotation.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include <palpate/error.hpp>

#include "fem/meshes.hpp"
#include "fem/plasticity.hpp"
#include "fem/rotation.hpp"

namespace palpate::fem::test {
namespace {

Material plastic_material(double yield, double creep, std::optional<double> maximum = {}) {
  return {.young_modulus = 2e4,
          .poisson_ratio = 0.3,
          .plastic_yield = yield,
          .plastic_creep = creep,
          .plastic_maximum = maximum};
}

std::vector<SymmetricMatrix3> random_strains(std::size_t count, double size, unsigned seed) {
  std::vector<SymmetricMatrix3> strains(count);
  std::mt19937_64 random(seed);
  for (SymmetricMatrix3& s : strains) {
    const Vec3 a = random_vector(random, size);
    const Vec3 b = random_vector(random, size);
    s = {a.x, a.y, a.z, b.x, b.y, b.z};
  }
  return strains;
}

double difference(const SymmetricMatrix3& a, const SymmetricMatrix3& b) {
  return norm(a + (-1.0) * b);
}

TEST(PlasticFlow, IsTheFormulaOfMuellerAndGross) {
  const SymmetricMatrix3 none;
  const SymmetricMatrix3 pull{0.1, 0.0, 0.0, 0.0, 0.0, 0.0};
  const Plasticity law{0.05, 20.0, {}};
  // h c = 0.2: a fifth of the elastic strain flows.
  SymmetricMatrix3 p = plastic_flow(none, pull, law, 0.01, 1.0, 0.0);
  EXPECT_NEAR(p.xx, 0.02, 1e-16);
  p = plastic_flow(p, pull, law, 0.01, 1.0, 0.0);
  EXPECT_NEAR(p.xx, 0.02 + 0.2 * 0.08, 1e-16);
  // Elastic strain at the yield or below: no flow.
  p = {0.05, 0.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(plastic_flow(p, pull, law, 0.01, 1.0, 0.0).xx, 0.05);
  // At most all of the elastic strain flows, however large the step.
  EXPECT_NEAR(plastic_flow(none, pull, law, 1.0, 1.0, 0.0).xx, 0.1, 1e-16);
  // Bounded by the maximum, in its direction.
  p = plastic_flow(none, pull, {0.05, 20.0, 0.015}, 0.01, 1.0, 0.0);
  EXPECT_NEAR(p.xx, 0.015, 1e-16);
  // Shear counts twice in the norm, as it does in the tensor: |e|^2 = 2 * 0.03^2.
  const SymmetricMatrix3 shear{0.0, 0.0, 0.0, 0.03, 0.0, 0.0};
  EXPECT_EQ(plastic_flow(none, shear, {0.0425, 1.0, {}}, 0.1, 1.0, 0.0).xy, 0.0);
  EXPECT_NEAR(plastic_flow(none, shear, {0.0424, 1.0, {}}, 0.1, 1.0, 0.0).xy, 0.003, 1e-16);
  // Without a yield there is no flow.
  EXPECT_EQ(plastic_flow(none, pull, {{}, 20.0, {}}, 0.01, 1.0, 0.0).xx, 0.0);
}

TEST(PlasticFlow, NeverGivesEnergy) {
  const auto totals = random_strains(4000, 0.5, 1);
  const auto plastics = random_strains(4000, 0.15, 2);
  int flowed = 0;
  for (std::size_t i = 0; i < totals.size(); ++i) {
    const double lambda =
        i % 2 == 0 ? 0.3 : 100.0;  // nearly incompressible: only then the bound can raise the energy
    const auto energy = [&](const SymmetricMatrix3& p) {
      const SymmetricMatrix3 e = totals[i] + (-1.0) * p;
      const double trace = e.xx + e.yy + e.zz;
      return norm(e) * norm(e) + 0.5 * lambda * trace * trace;
    };
    const auto next = plastic_flow(plastics[i], totals[i], {0.1, 30.0, 0.4}, 0.01, 1.0, lambda);
    EXPECT_LE(energy(next), energy(plastics[i]));
    EXPECT_LE(norm(next), std::max(0.4 * (1.0 + 1e-15), norm(plastics[i])));
    flowed += difference(next, plastics[i]) > 0.0 ? 1 : 0;
  }
  EXPECT_GT(flowed, 2000);
  // In nearly incompressible tissue the bound would raise the energy of a swelling: from 0.02 to 0.08.
  const SymmetricMatrix3 swollen{0.2, 0.2, 0.2, 0.0, 0.0, 0.0};
  const SymmetricMatrix3 sheared{0.2, 0.2, 0.2, 0.1, 0.0, 0.0};
  EXPECT_EQ(plastic_flow(swollen, sheared, {0.05, 100.0, 0.35}, 0.01, 1.0, 100.0).xy, 0.0);
  EXPECT_GT(plastic_flow(swollen, sheared, {0.05, 100.0, 0.35}, 0.01, 1.0, 0.0).xy, 0.09);
}

/// A body with all points held, so that the test sets its strain.
struct HeldBody {
  explicit HeldBody(const Material& material)
      : bodies(single_body(box_mesh({3, 2, 2}, {0.3, 0.2, 0.2}))),
        dynamics(
            Scene{material, std::vector<std::uint8_t>(bodies.points_rest().size(), 1), 1}.dynamics(bodies)) {}

  void step_at(const Matrix3& f, double h) {
    dynamics.set_positions(mapped(bodies, [&](const Vec3& p) { return f * p; }));
    dynamics.step(h, {}, {}, {}, 1e-8, 100);
  }
  void expect_strain(const SymmetricMatrix3& expected, double tolerance = 1e-14) const {
    ASSERT_EQ(dynamics.plastic_strains().size(), bodies.tets().size());
    for (const auto& p : dynamics.plastic_strains()) EXPECT_LT(difference(p, expected), tolerance) << p.xx;
  }

  Bodies bodies;
  Dynamics dynamics;
};

Matrix3 pulled(double strain) {
  return {{1.0 + strain, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
}

TEST(Plasticity, UniformPullLeavesTheStrainThatHandCalculationGives) {
  HeldBody body(plastic_material(0.05, 20.0));
  double expected = 0.0;
  for (int n = 0; n < 30; ++n) {
    body.step_at(pulled(0.2), 0.01);
    if (0.2 - expected > 0.05) expected += 0.2 * (0.2 - expected);
    body.expect_strain({expected, 0.0, 0.0, 0.0, 0.0, 0.0});
  }
  // 0.2 (1 - 0.8^n): the first value within 0.05 of 0.2 is that of n = 7.
  EXPECT_NEAR(expected, 0.2 * (1.0 - std::pow(0.8, 7)), 1e-15);
  // Back at rest the elastic strain is -0.158: it yields the other way until that is within 0.05.
  for (int n = 0; n < 30; ++n) body.step_at(pulled(0.0), 0.01);
  EXPECT_NEAR(body.dynamics.plastic_strains()[0].xx, expected * std::pow(0.8, 6), 1e-14);
}

TEST(Plasticity, BelowTheYieldNothingStays) {
  HeldBody body(plastic_material(0.21, 50.0));
  for (int n = 0; n < 50; ++n) body.step_at(pulled(n % 2 == 0 ? 0.2 : -0.2), 0.01);
  for (const auto& p : body.dynamics.plastic_strains()) EXPECT_EQ(norm(p), 0.0);
  // And a free body comes back to rest as an elastic one does, bit for bit.
  const Bodies bodies = single_body(box_mesh({3, 2, 2}, {0.3, 0.2, 0.2}));
  const auto run = [&](Material material) {
    material.stiffness_damping = 0.01;
    Dynamics dynamics = Scene{material, {}, 1}.dynamics(bodies);
    dynamics.set_positions(mapped(bodies, [](const Vec3& p) { return pulled(0.1) * p; }));
    for (int n = 0; n < 100; ++n) dynamics.step(0.01, {}, {}, {}, 1e-8, 500);
    return std::vector<Vec3>(dynamics.positions().begin(), dynamics.positions().end());
  };
  Material elastic = plastic_material(0.2, 50.0);
  elastic.plastic_yield.reset();
  EXPECT_EQ(run(plastic_material(0.2, 50.0)), run(elastic));
}

TEST(Plasticity, TheMaximumBoundsIt) {
  HeldBody body(plastic_material(0.01, 20.0, 0.06));
  for (int n = 0; n < 40; ++n) body.step_at(pulled(0.2), 0.01);
  body.expect_strain({0.06, 0.0, 0.0, 0.0, 0.0, 0.0});
}

TEST(Plasticity, TheFrameOfTheStrainTurnsWithTheBody) {
  // Pulled along its rotated x axis: the plastic strain is the same as without the rotation.
  std::mt19937_64 random(3);
  HeldBody body(plastic_material(0.05, 20.0));
  for (int n = 0; n < 20; ++n) {
    const Matrix3 rotation = random_rotation(random);
    body.step_at(from_eigen(to_eigen(rotation) * to_eigen(pulled(0.2))), 0.01);
  }
  body.expect_strain({0.2 * (1.0 - std::pow(0.8, 7)), 0.0, 0.0, 0.0, 0.0, 0.0});
}

TEST(Plasticity, AReleasedBarKeepsItsPermanentStrain) {
  // Pulled by 20 % until the plastic strain is 0.158, then free and damped: the shape without stress is
  // diag(1.158, 1, 1), which all tets share, so the bar comes to rest in it without any stress.
  const Bodies bodies = single_body(box_mesh({3, 2, 2}, {0.3, 0.2, 0.2}));
  Material material = plastic_material(0.05, 20.0);
  HeldBody held(material);
  for (int n = 0; n < 10; ++n) held.step_at(pulled(0.2), 0.01);
  const double permanent = 0.2 * (1.0 - std::pow(0.8, 7));
  material.stiffness_damping = 0.02;
  Dynamics dynamics = Scene{material, {}, 1}.dynamics(bodies);
  dynamics.set_positions(held.dynamics.positions());
  dynamics.set_plastic_strains(held.dynamics.plastic_strains());
  for (int n = 0; n < 400; ++n) dynamics.step(0.01, {}, {}, {}, 1e-10, 500);
  const auto middle = [](std::span<const Vec3> x) {
    return (1.0 / static_cast<double>(x.size())) * total(x);
  };
  const auto expected = mapped(bodies, [&](const Vec3& p) { return pulled(permanent) * p; });
  const Vec3 shift = middle(dynamics.positions()) - middle(expected);
  auto found = std::vector<Vec3>(dynamics.positions().begin(), dynamics.positions().end());
  for (Vec3& p : found) p -= shift;
  EXPECT_LT(largest_distance(found, expected), 1e-6);
  EXPECT_LT(dynamics.elastic_energy(), 1e-10);
}

TEST(Plasticity, ForceIsMinusTheDerivativeOfTheEnergyAtFixedPlasticStrain) {
  std::mt19937_64 random(4);
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}, 0.2));
  Elements elements(bodies, {plastic_material(0.05, 20.0)}, std::vector<std::uint8_t>{0});
  // Random axes in each tet, different from those of the strain.
  elements.set_plastic_strains(random_strains(bodies.tets().size(), 0.2, 5));
  for (int trial = 0; trial < 5; ++trial) {
    const Matrix3 r = random_rotation(random);
    auto positions = mapped(bodies, [&](const Vec3& p) { return r * (p + random_vector(random, 0.1)); });
    elements.update(one_thread, positions);
    const auto forces = point_forces(elements);
    Vec3 torque;
    for (std::size_t i = 0; i < forces.size(); ++i) torque += cross(positions[i], forces[i]);
    EXPECT_LT(length(torque), 1e-11 * largest(forces)) << "no torque of their own";
    constexpr double step = 1e-6;
    for (std::size_t i = 0; i < positions.size(); ++i) {
      for (double Vec3::*axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
        const double center = positions[i].*axis;
        positions[i].*axis = center + step;
        const double above = total_energy(elements, positions);
        positions[i].*axis = center - step;
        const double below = total_energy(elements, positions);
        positions[i].*axis = center;
        EXPECT_NEAR(forces[i].*axis, -(above - below) / (2.0 * step), 1e-7 * largest(forces)) << i;
      }
    }
  }
}

TEST(Plasticity, ATurnedPlasticBodyHasTheTurnedForces) {
  std::mt19937_64 random(6);
  const Bodies bodies = single_body(irregular_box_mesh({2, 2, 2}, {1.0, 1.0, 1.0}, 0.2));
  Elements elements(bodies, {plastic_material(0.05, 20.0)}, std::vector<std::uint8_t>{0});
  elements.set_plastic_strains(random_strains(bodies.tets().size(), 0.2, 7));
  const auto positions = noisy(bodies, 0.05, 8);
  elements.update(one_thread, positions);
  const auto forces = point_forces(elements);
  const double energy = total_energy(elements, positions);
  for (int trial = 0; trial < 5; ++trial) {
    const Matrix3 r = random_rotation(random);
    std::vector<Vec3> turned;
    for (const Vec3& p : positions) turned.push_back(r * p + Vec3{1.0, 2.0, 3.0});
    elements.update(one_thread, turned);
    const auto turned_forces = point_forces(elements);
    std::vector<Vec3> expected;
    for (const Vec3& f : forces) expected.push_back(r * f);
    EXPECT_LT(largest_distance(turned_forces, expected), 1e-11 * largest(forces));
    EXPECT_NEAR(total_energy(elements, turned), energy, 1e-11 * energy);
  }
  // In its stress-free shape, under any rotation, all forces are zero.
  Elements bar(bodies, {plastic_material(0.05, 20.0)}, std::vector<std::uint8_t>{0});
  const SymmetricMatrix3 strain{0.15, -0.05, 0.02, 0.03, -0.04, 0.01};
  bar.set_plastic_strains(std::vector<SymmetricMatrix3>(bodies.tets().size(), strain));
  for (int trial = 0; trial < 5; ++trial) {
    const Matrix3 r = random_rotation(random);
    bar.update(one_thread, mapped(bodies, [&](const Vec3& p) { return r * (p + strain * p); }));
    EXPECT_LT(largest(point_forces(bar)), 1e-14 * 2e4);
  }
}

TEST(Plasticity, ATwistIsBoundedWhereAnElementIsFlatOrInverted) {
  const auto plastics = random_strains(200, 0.3, 9);
  for (const SymmetricMatrix3& p : plastics) {
    for (const double last : {1.0, 0.01, 0.0, -0.5, -0.9999999, -1.0, -2.0}) {
      const Vec3 w = plastic_twist({1.0, 1.0, last, 0.0, 0.0, 0.0}, p);
      EXPECT_LE(length(w), norm(p) / std::sqrt(2.0) * (1.0 + 1e-15)) << last;
    }
    EXPECT_TRUE(is_finite(plastic_twist({}, p)));
  }
}

TEST(Plasticity, ABodyWithPlasticStrainsRecoversFromInversion) {
  const Bodies bodies = single_body(box_mesh({2, 2, 2}, {0.2, 0.2, 0.2}));
  Material material = plastic_material(0.05, 50.0, 0.3);
  material.mass_damping = 1.0;
  material.stiffness_damping = 0.01;
  Dynamics dynamics = Scene{material, {}, 1}.dynamics(bodies);
  dynamics.set_positions(mapped(bodies, [](const Vec3& p) { return Vec3{p.x, p.y, -0.3 * p.z}; }));
  dynamics.set_plastic_strains(random_strains(bodies.tets().size(), 0.1, 10));
  double energy = dynamics.elastic_energy();
  for (int n = 0; n < 600; ++n) {
    dynamics.step(0.01, {}, {}, {}, 1e-8, 2000);
    ASSERT_TRUE(std::isfinite(largest(dynamics.positions()))) << n;
  }
  EXPECT_LT(dynamics.elastic_energy(), 0.01 * energy);
  Elements elements(bodies, {material}, std::vector<std::uint8_t>{0});
  elements.update(one_thread, dynamics.positions());
  for (Index e = 0; e < elements.size(); ++e) EXPECT_FALSE(elements.inverted(e)) << e;
}

TEST(Plasticity, DampedEnergyDoesNotGrowWhileItYields) {
  const Bodies bodies = single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2));
  Material material = plastic_material(0.03, 20.0, 0.5);
  material.mass_damping = 0.5;
  material.stiffness_damping = 0.005;
  Dynamics dynamics = Scene{material, {}, 1}.dynamics(bodies);
  dynamics.set_positions(mapped(bodies, [](const Vec3& p) {
    return Vec3{1.3 * p.x + 0.3 * p.y, 0.8 * p.y, p.z + 0.5 * p.x * p.y};
  }));
  double energy = dynamics.elastic_energy();
  for (int n = 0; n < 300; ++n) {
    dynamics.step(0.01, {}, {}, {}, 1e-8, 2000);
    const double next = dynamics.elastic_energy() + dynamics.kinetic_energy();
    EXPECT_LE(next, energy * (1.0 + 1e-9)) << "step " << n;
    energy = next;
  }
  double largest_strain = 0.0;
  for (const auto& p : dynamics.plastic_strains()) largest_strain = std::max(largest_strain, norm(p));
  EXPECT_GT(largest_strain, 0.05) << "it did yield";
}

TEST(Plasticity, TheStateCarriesOnInTheSameBitsForEveryThreadCount) {
  const Bodies bodies = single_body(irregular_box_mesh({8, 8, 8}, {0.5, 0.5, 0.5}, 0.2));
  const Material material = plastic_material(0.02, 10.0);
  const auto start = noisy(bodies, 0.02, 11);
  const auto state_after = [&](int threads, int resume_at) {
    Dynamics first = Scene{material, {}, threads}.dynamics(bodies);
    first.set_positions(start);
    for (int n = 0; n < resume_at; ++n) first.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 60);
    Dynamics second = Scene{material, {}, threads}.dynamics(bodies);
    second.set_positions(first.positions());
    second.set_velocities(first.velocities());
    second.set_velocity_changes(first.velocity_changes());
    second.set_plastic_strains(first.plastic_strains());
    second.set_inversion_clocks(first.inversion_clocks());
    for (int n = resume_at; n < 8; ++n) second.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 60);
    std::vector<Vec3> state(second.positions().begin(), second.positions().end());
    for (const auto& p : second.plastic_strains()) {
      state.push_back({p.xx, p.yy, p.zz});
      state.push_back({p.xy, p.xz, p.yz});
    }
    EXPECT_GT(norm(second.plastic_strains()[100]), 0.0);
    return state;
  };
  const auto expected = state_after(1, 0);
  EXPECT_EQ(state_after(1, 4), expected);
  for (const int threads : {2, 3, 7}) EXPECT_EQ(state_after(threads, 3), expected) << threads;
}

TEST(Plasticity, BadValuesAreRefused) {
  const Bodies bodies = single_body(unit_tet_mesh());
  const auto message = [&](const Material& material) -> std::string {
    try {
      static_cast<void>(Scene{material, {}, 1}.dynamics(bodies));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(plastic_material(0.0, 0.0, 0.0)), "accepted");
  EXPECT_EQ(message(plastic_material(-0.1, 1.0)),
            "body body: plastic_yield: found -0.1, expected a number >= 0");
  EXPECT_EQ(message(plastic_material(0.1, -1.0)),
            "body body: plastic_creep: found -1, expected a number >= 0 (1/s)");
  EXPECT_EQ(message(plastic_material(0.1, 1.0, -2.0)),
            "body body: plastic_maximum: found -2, expected a number >= 0");
  Dynamics dynamics = Scene{plastic_material(0.1, 1.0), {}, 1}.dynamics(bodies);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(dynamics.set_plastic_strains(std::vector<SymmetricMatrix3>(2)), Error);
  EXPECT_THROW(dynamics.set_plastic_strains(std::vector<SymmetricMatrix3>{{nan, 0, 0, 0, 0, 0}}), Error);
  EXPECT_EQ(norm(dynamics.plastic_strains()[0]), 0.0);
}

}  // namespace
}  // namespace palpate::fem::test

// Several materials in a body. Oracles: springs in series, sums of masses, and bodies of one material.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr Vec3 size{0.4, 0.1, 0.1};

/// Material 0 for tets left of the middle of the bar, 1 for the others.
std::vector<Index> halves(const Bodies& bodies) {
  std::vector<Index> materials;
  for (const Tet& t : bodies.tets()) {
    double x = 0.0;
    for (const Index p : t) x += 0.25 * at(bodies.points_rest(), p).x;
    materials.push_back(x < 0.5 * size.x ? 0 : 1);
  }
  return materials;
}

Bodies bar() {
  return single_body(box_mesh({8, 2, 2}, size));
}

/// Poisson's ratio is 0, so that each half is under uniform stress.
std::vector<Material> soft_and_hard() {
  return {{.young_modulus = 1e4, .poisson_ratio = 0.0}, {.young_modulus = 4e4, .poisson_ratio = 0.0}};
}

TEST(Regions, ABarOfTwoHalvesStretchesAsTwoSpringsInSeries) {
  const Bodies bodies = bar();
  const auto fixed = select(bodies, [](const Vec3& p) { return p.x == 0.0; });
  Dynamics dynamics(bodies, {soft_and_hard(), halves(bodies)}, fixed, {0}, parallel::Threads(1));
  constexpr double force = 0.01;
  std::vector<Vec3> forces(fixed.size());
  for (const Triangle& t : bodies.triangles()) {
    const auto rest = bodies.points_rest();
    const Vec3 a = at(rest, t[0]);
    if (!(a.x == size.x && at(rest, t[1]).x == size.x && at(rest, t[2]).x == size.x)) continue;
    const double area = 0.5 * length(cross(at(rest, t[1]) - a, at(rest, t[2]) - a));
    for (const Index p : t) at(forces, p).x += area / 3.0 * force / (size.y * size.z);
  }
  ASSERT_NEAR(total(forces).x, force, 1e-15);
  settle(dynamics, forces, 10);
  // k = E A / l of each half: strain of force / (E A), exact for corotational tets too, since nothing
  // rotates.
  const double strain_soft = force / (1e4 * size.y * size.z);
  const double strain_hard = force / (4e4 * size.y * size.z);
  const auto expected = mapped(bodies, [&](const Vec3& p) {
    const double soft = std::min(p.x, 0.5 * size.x);
    return Vec3{p.x + strain_soft * soft + strain_hard * (p.x - soft), p.y, p.z};
  });
  EXPECT_LT(largest_distance(dynamics.positions(), expected), 1e-8 * strain_soft);
  const double spring = 1.0 / (0.2 / (1e4 * 0.01) + 0.2 / (4e4 * 0.01));
  EXPECT_NEAR(expected.back().x - size.x, force / spring, 1e-12);
}

TEST(Regions, MassesAndTheirDampingAreThoseOfTheTets) {
  const Bodies bodies = bar();
  auto materials = soft_and_hard();
  materials[1].density = 3000.0;
  materials[1].mass_damping = 4.0;
  Dynamics dynamics(bodies, {materials, halves(bodies)},
                    std::vector<std::uint8_t>(bodies.points_rest().size()), {0}, parallel::Threads(1));
  double left = 0.0;
  double right = 0.0;
  double all = 0.0;
  for (std::size_t p = 0; p < bodies.points_rest().size(); ++p) {
    const double x = bodies.points_rest()[p].x;
    all += dynamics.point_masses()[p];
    if (x < 0.19) left += dynamics.point_masses()[p];
    if (x > 0.21) right += dynamics.point_masses()[p];
  }
  EXPECT_NEAR(all, 0.002 * 1000.0 + 0.002 * 3000.0, 1e-12);
  EXPECT_NEAR(right / left, 3.0, 1e-9);
  // All points have one speed in a short step. Damping removes the momentum m a h v: only the right half's
  // mass is damped, with 4 per second.
  std::vector<Vec3> start(bodies.points_rest().size(), {0.0, 0.0, 1.0});
  dynamics.set_velocities(start);
  constexpr double h = 1e-7;  // so short that no stress comes about
  dynamics.step(h, {}, {}, {}, 1e-14, 1000);
  double lost = 0.0;
  for (std::size_t p = 0; p < start.size(); ++p)
    lost += dynamics.point_masses()[p] * (1.0 - dynamics.velocities()[p].z);
  EXPECT_NEAR(lost / h, 4.0 * 0.002 * 3000.0, 1e-4);
}

TEST(Regions, OneMaterialByTetIsTheSameBitsAsByBody) {
  const Bodies bodies = bar();
  Material material{.young_modulus = 2e4, .mass_damping = 0.3, .stiffness_damping = 0.003};
  const auto run = [&](const Materials& materials) {
    Dynamics dynamics(bodies, materials, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), {0},
                      parallel::Threads(2));
    for (int n = 0; n < 20; ++n) dynamics.step(0.01, {0.0, 0.0, -9.81}, {}, {}, 1e-5, 200);
    return std::vector<Vec3>(dynamics.positions().begin(), dynamics.positions().end());
  };
  const Material unused{.mass_damping = 0.3};
  EXPECT_EQ(run({{unused, material}, std::vector<Index>(bodies.tets().size(), 1)}), run({material}));
}

TEST(Regions, OnlyTheRegionThatCanYieldDoes) {
  const Bodies bodies = bar();
  auto materials = soft_and_hard();
  materials[1].plastic_yield = 0.01;
  materials[1].plastic_creep = 10.0;
  Dynamics dynamics(bodies, {materials, halves(bodies)},
                    std::vector<std::uint8_t>(bodies.points_rest().size(), 1), {0}, parallel::Threads(1));
  dynamics.set_positions(mapped(bodies, [](const Vec3& p) { return Vec3{1.1 * p.x, p.y, p.z}; }));
  dynamics.step(0.01, {}, {}, {}, 1e-5, 10);
  const auto half = halves(bodies);
  ASSERT_EQ(dynamics.plastic_strains().size(), half.size());
  for (std::size_t e = 0; e < half.size(); ++e) {
    const Index tet = dynamics.tet_of_element()[e];
    EXPECT_NEAR(dynamics.plastic_strains()[e].xx, at(half, tet) == 1 ? 0.1 * 0.1 : 0.0, 1e-15) << tet;
  }
}

TEST(Regions, BadListsAreRefused) {
  const Bodies bodies = bar();
  const auto message = [&](const Materials& materials) -> std::string {
    try {
      Dynamics(bodies, materials, std::vector<std::uint8_t>(bodies.points_rest().size()), {0},
               parallel::Threads(1));
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message({soft_and_hard(), std::vector<Index>(160, 1)}), "accepted");
  EXPECT_EQ(message(Materials(soft_and_hard())),
            "dynamics: materials: found 2 values, expected 1 values, one per body");
  EXPECT_EQ(message({soft_and_hard(), std::vector<Index>(159, 1)}),
            "dynamics: material of tets: found 159 values, expected 160 values, one per tet");
  EXPECT_EQ(message({soft_and_hard(), std::vector<Index>(160, 2)}),
            "dynamics: material of tets: found 2, expected an index of 2 materials");
  EXPECT_EQ(message({soft_and_hard(), std::vector<Index>(160, -1)}),
            "dynamics: material of tets: found -1, expected an index of 2 materials");
  auto bad = soft_and_hard();
  bad[1].density = 0.0;
  EXPECT_EQ(message({bad, std::vector<Index>(160, 1)}),
            "material 1: density: found 0, expected a number > 0 (kg/m^3)");
}

}  // namespace
}  // namespace palpate::fem::test

#include <gtest/gtest.h>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

/// The surface of an irregular box is held at an affine map of its rest position; the inside must follow the
/// map.
void expect_patch(const Matrix3& map, int steps, double tolerance) {
  constexpr Vec3 size{1.0, 0.8, 0.6};
  const Bodies bodies = single_body(irregular_box_mesh({4, 4, 4}, size, 0.25));
  const auto fixed = select(bodies, [&](const Vec3& p) { return on_surface(p, size); });
  const Material undamped{1e5, 0.3, 1000.0, 0.0, 0.0};
  Dynamics dynamics = Scene{undamped, fixed, 1}.dynamics(bodies);
  const auto expected = mapped(bodies, [&](const Vec3& p) { return map * p + Vec3{0.3, -0.2, 0.1}; });
  auto start = expected;
  const auto noise = random_vectors(start.size(), 0.02, 81);
  int inner_points = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (fixed[i] != 0) continue;
    start[i] += noise[i];
    ++inner_points;
  }
  ASSERT_EQ(inner_points, 27);
  ASSERT_GT(largest_distance(start, expected), 0.01);
  dynamics.set_positions(start);
  settle(dynamics, {}, steps);
  EXPECT_LT(largest_distance(dynamics.positions(), expected), tolerance);
}

TEST(PatchTest, SmallAffineStrain) {
  expect_patch({{1.001, 0.0005, -0.0003, 0.0005, 0.9992, 0.0007, -0.0003, 0.0007, 1.0004}}, 40, 1e-12);
}

TEST(PatchTest, LargeAffineStrain) {
  expect_patch({{1.2, 0.1, 0.0, 0.05, 0.9, -0.1, 0.0, 0.1, 1.1}}, 80, 1e-12);
}

/// A bar pulled at both ends: strain = stress / E and lateral strain = -nu stress / E, for uniform stress.
TEST(Statics, UniaxialPullFollowsHooke) {
  constexpr Vec3 size{0.4, 0.2, 0.2};
  const Bodies bodies = single_body(box_mesh({4, 2, 2}, size));
  const Material material{1e5, 0.3, 1000.0, 0.0, 0.0};
  constexpr double strain = 1e-4;
  Dynamics dynamics =
      Scene{material, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 1}.dynamics(bodies);
  // Held points follow the lateral contraction too, so that the stress is uniform.
  const auto expected = mapped(bodies, [&](const Vec3& p) {
    return Vec3{p.x * (1.0 + strain), p.y * (1.0 - 0.3 * strain), p.z * (1.0 - 0.3 * strain)};
  });
  auto start = mapped(bodies, [](const Vec3& p) { return p; });
  for (std::size_t i = 0; i < start.size(); ++i) {
    if (start[i].x == 0.0) start[i] = expected[i];
  }
  dynamics.set_positions(start);
  // Consistent loads of a uniform traction: a third of each end triangle to each of its points.
  std::vector<Vec3> forces(start.size());
  for (const Triangle& t : bodies.triangles()) {
    const auto rest = bodies.points_rest();
    const Vec3 a = at(rest, t[0]);
    if (!(a.x == size.x && at(rest, t[1]).x == size.x && at(rest, t[2]).x == size.x)) continue;
    const double area = 0.5 * length(cross(at(rest, t[1]) - a, at(rest, t[2]) - a));
    for (const Index p : t) at(forces, p).x += area / 3.0 * material.young_modulus * strain;
  }
  ASSERT_NEAR(total(forces).x, 0.04 * 1e5 * strain, 1e-15);
  settle(dynamics, forces, 10);
  EXPECT_LT(largest_distance(dynamics.positions(), expected), 1e-5 * strain);
}

}  // namespace
}  // namespace palpate::fem::test

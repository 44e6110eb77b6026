// The kernels of the dynamics on every SIMD target that this processor has, against their twins in plain C++.
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/block_matrix.hpp"
#include "fem/meshes.hpp"
#include "simd/block_rows.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

const parallel::Threads one_thread(1);

/// Healthy, strongly strained, flat, inverted and collapsed elements side by side, and a number of them that
/// is no multiple of any number of lanes.
struct ElementCase {
  ElementCase() : bodies(single_body(irregular_box_mesh({5, 3, 3}, {0.5, 0.3, 0.3}, 0.2))) {
    positions = noisy(bodies, 0.02, 80);
    std::mt19937_64 random(81);
    const Matrix3 turn = random_rotation(random);
    for (Vec3& p : positions) p = turn * p;
    for (std::size_t t = 0; t < bodies.tets().size(); t += 17) {
      const Tet& corners = bodies.tets()[t];
      const Vec3 middle =
          1.0 / 3.0 * (at(positions, corners[1]) + at(positions, corners[2]) + at(positions, corners[3]));
      const double beyond = t % 3 == 0 ? 0.0 : 1.5;  // flat, or inside out
      at(positions, corners[0]) += (1.0 + beyond) * (middle - at(positions, corners[0]));
    }
    const Tet& last = bodies.tets().back();
    for (const Index corner : last) at(positions, corner) = {};
  }
  [[nodiscard]] Elements elements() const {
    return {bodies, std::vector<Material>(1, {5e4, 0.4, 1000.0, 0.0, 0.0}), std::vector<std::uint8_t>(1, 0)};
  }
  Bodies bodies;
  std::vector<Vec3> positions;
};

TEST(SimdTargets, ElementPassEqualsOneByOne) {
  const ElementCase c;
  Elements expected = c.elements();
  ASSERT_NE(expected.size() % 16, 0);
  std::vector<double> factors;
  for (Index e = 0; e < expected.size(); ++e) factors.push_back(1e-4 * (1 + e % 5));
  expected.set_factors(factors);
  expected.update_one_by_one(c.positions);
  int targets = 0;
  palpate::test::for_each_simd_target([&](const char* target) {
    ++targets;
    Elements elements = c.elements();
    elements.set_factors(factors);
    elements.update(one_thread, c.positions);
    int inverted = 0;
    for (Index e = 0; e < elements.size(); ++e) {
      double size = 0.0;
      for (int k = 0; k < 4; ++k) size = std::max(size, length(expected.force(e, k)));
      for (int k = 0; k < 4; ++k) {
        ASSERT_LT(length(elements.force(e, k) - expected.force(e, k)), 1e-12 * size) << target << ", " << e;
        const simd::Padded3 a = at(elements.gradients(), 4 * e + k);
        const simd::Padded3 b = at(expected.gradients(), 4 * e + k);
        ASSERT_LT(length(Vec3{a.x - b.x, a.y - b.y, a.z - b.z}), 1e-12 * length({b.x, b.y, b.z})) << target;
        ASSERT_EQ(a.w, 0.0);
      }
      ASSERT_NEAR(elements.energy(e), expected.energy(e), 1e-12 * expected.energy(e)) << target;
      ASSERT_NEAR(expected.energy(e, c.positions), expected.energy(e), 1e-14 * expected.energy(e));
      ASSERT_EQ(elements.inverted(e), expected.inverted(e)) << target << ", " << e;
      inverted += elements.inverted(e) ? 1 : 0;
    }
    ASSERT_GT(inverted, 3);
  });
  EXPECT_GT(targets, 1);
}

std::vector<simd::Padded3> random_rows(std::size_t count, unsigned seed) {
  return padded(random_vectors(count, 1.0, seed));
}

Eigen::VectorXd flat(const std::vector<simd::Padded3>& rows) {
  return to_eigen(unpadded(rows));
}

void expect_near(const std::vector<simd::Padded3>& found, const std::vector<simd::Padded3>& expected,
                 const char* target) {
  EXPECT_LT((flat(found) - flat(expected)).norm(), 1e-13 * flat(expected).norm()) << target;
  for (const simd::Padded3& row : found) ASSERT_EQ(row.w, 0.0) << target;
}

struct RowsCase {
  RowsCase() : elements(shapes.elements()), free(shapes.positions.size(), 1), matrix(elements, free) {
    elements.update(one_thread, noisy(shapes.bodies, 0.02, 82));
    std::mt19937_64 random(83);
    std::uniform_real_distribution<double> uniform(0.5, 2.0);
    for (std::size_t i = 0; i < free.size(); ++i) masses.push_back(uniform(random));
    for (std::size_t i = 0; i < 12 * free.size(); ++i) {
      inverse_diagonal.push_back({uniform(random), 0.1 * uniform(random), uniform(random), 0.0});
    }
    for (std::int32_t c = 0; c < 50; ++c) {
      Coupling coupling;
      coupling.points = {c, c + 3, c % 7 == 0 ? -1 : c + 9, c + 11, c + 5};
      coupling.coefficients = {1.0, -uniform(random), -0.3, 0.2, 0.7};
      coupling.stiffness = {2.0 * uniform(random), uniform(random), 3.0, 0.1, 0.2, 0.3};
      list.push_back(coupling);
    }
    couplings.set(list, 0.5, free);
  }
  ElementCase shapes;
  Elements elements;
  std::vector<std::uint8_t> free;
  BlockMatrix matrix;
  std::vector<double> masses;
  std::vector<simd::Padded3> inverse_diagonal;
  std::vector<Coupling> list;
  CouplingSystem couplings;
};

TEST(SimdTargets, AssemblyAndProductEqualTheirTwins) {
  RowsCase c;
  const std::size_t n = c.free.size();
  const auto x = random_rows(n, 84);
  std::vector<Eigen::VectorXd> results;
  palpate::test::for_each_simd_target([&](const char* target) {
    c.matrix.assemble(one_thread, c.elements, c.masses);
    c.couplings.multiply(one_thread, x);
    std::vector<simd::Padded3> y(n, {7.0, 7.0, 7.0, 7.0});
    std::vector<simd::Padded3> twin(n, {7.0, 7.0, 7.0, 7.0});
    const double inner = simd::multiply_rows(c.matrix.rows(), c.couplings.rows(), x.data(), y.data(), 0, n);
    const double expected =
        simd::scalar::multiply_rows(c.matrix.rows(), c.couplings.rows(), x.data(), twin.data(), 0, n);
    EXPECT_NEAR(inner, expected, 1e-13 * std::abs(expected)) << target;
    expect_near(y, twin, target);
    results.push_back(flat(y));
    EXPECT_LT((results.back() - results.front()).norm(), 1e-13 * results.front().norm()) << target;
  });
  EXPECT_GT(results.front().norm(), 0.0);
}

TEST(SimdTargets, VectorPassesEqualTheirTwins) {
  const RowsCase c;
  const std::size_t n = c.free.size();
  const std::vector<double> inverse_masses(c.masses.rbegin(), c.masses.rend());
  struct Vectors {
    std::vector<simd::Padded3> x, r, z, p, q;
  };
  const Vectors start{random_rows(n, 85), random_rows(n, 86), random_rows(n, 87), random_rows(n, 88),
                      random_rows(n, 89)};
  const auto view = [&](Vectors& v) {
    return simd::GradientVectors{v.x.data(),      v.r.data(),           v.z.data(),
                                 v.p.data(),      v.q.data(),           &c.inverse_diagonal.data()->x,
                                 c.masses.data(), inverse_masses.data()};
  };
  palpate::test::for_each_simd_target([&](const char* target) {
    Vectors found = start;
    Vectors twin = start;
    const simd::VectorSums sums = simd::advance_rows(view(found), 0.7, 3, n - 2);
    const simd::VectorSums expected = simd::scalar::advance_rows(view(twin), 0.7, 3, n - 2);
    EXPECT_NEAR(sums.residual, expected.residual, 1e-13 * expected.residual) << target;
    EXPECT_NEAR(sums.by_mass, expected.by_mass, 1e-13 * expected.by_mass) << target;
    EXPECT_NEAR(sums.solution, expected.solution, 1e-13 * expected.solution) << target;
    EXPECT_NEAR(sums.preconditioned, expected.preconditioned, 1e-12 * expected.residual) << target;
    simd::turn_rows(view(found), -0.3, 3, n - 2);
    simd::scalar::turn_rows(view(twin), -0.3, 3, n - 2);
    expect_near(found.x, twin.x, target);
    expect_near(found.r, twin.r, target);
    expect_near(found.z, twin.z, target);
    expect_near(found.p, twin.p, target);
    EXPECT_EQ(found.x[2].x, start.x[2].x) << "outside of the range";
    EXPECT_NE(found.x[3].x, start.x[3].x);
  });
}

}  // namespace
}  // namespace palpate::fem::test

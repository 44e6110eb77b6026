// The kernels of the dynamics on every SIMD target of this processor, against the same in plain C++.
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/block_matrix.hpp"
#include "fem/meshes.hpp"
#include "fem/stress.hpp"
#include "fem/symmetric_eigen.hpp"
#include "fem/system.hpp"
#include "fem/tissue.hpp"
#include "simd/element_pass.hpp"
#include "simd/sliced_rows.hpp"
#include "simd/stress_pass.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

/// Healthy, strongly strained, flat, inverted and collapsed elements side by side. Their number is no
/// multiple of the lanes of any target.
struct ElementCase {
  ElementCase() : bodies(single_body(irregular_box_mesh({5, 3, 3}, {0.5, 0.3, 0.3}, 0.2))) {
    positions = noisy(bodies, 0.02, 80);
    std::mt19937_64 random(81);
    const Matrix3 rotation = random_rotation(random);
    for (Vec3& p : positions) p = rotation * p;
    for (std::size_t t = 0; t < bodies.tets().size(); t += 17) {
      const Tet& corners = bodies.tets()[t];
      const Vec3 middle =
          1.0 / 3.0 * (at(positions, corners[1]) + at(positions, corners[2]) + at(positions, corners[3]));
      const double beyond = t % 3 == 0 ? 0.0 : 1.5;  // flat or inverted
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
  const auto corners = 4 * static_cast<std::size_t>(expected.size());
  std::vector<simd::Padded3> expected_forces(corners);
  expected.update_one_by_one(c.positions, expected_forces);
  int targets = 0;
  palpate::test::for_each_simd_target([&](const char* target) {
    ++targets;
    Elements elements = c.elements();
    elements.set_factors(factors);
    std::vector<simd::Padded3> found_forces(corners);
    elements.update(one_thread, c.positions, found_forces);
    const auto force = [](const std::vector<simd::Padded3>& forces, Index e, int k) {
      const simd::Padded3& f = at(forces, 4 * e + k);
      return Vec3{f.x, f.y, f.z};
    };
    int inverted = 0;
    for (Index e = 0; e < elements.size(); ++e) {
      double size = 0.0;
      for (int k = 0; k < 4; ++k) size = std::max(size, length(force(expected_forces, e, k)));
      for (int k = 0; k < 4; ++k) {
        const Vec3 difference = force(found_forces, e, k) - force(expected_forces, e, k);
        ASSERT_LT(length(difference), 1e-12 * size) << target << ", " << e;
        const Vec3 a = expected.gradient(e, k);
        ASSERT_LT(length(elements.gradient(e, k) - a), 1e-12 * length(a)) << target;
        const simd::Quad row = at(elements.gradients(), 4 * e + k);
        const Vec3 rounded{static_cast<double>(row.x), static_cast<double>(row.y),
                           static_cast<double>(row.z)};
        ASSERT_LT(length(rounded - a), 1e-7 * length(a)) << target;
        ASSERT_EQ(row.w, static_cast<float>(at(expected.ratios(), e)));
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

/// Strain, stress and derived values; the pass leaves one of the tets to the caller.
TEST(SimdTargets, FieldsOfTetsEqualThoseOfOneByOne) {
  const ElementCase c;
  Elements elements = c.elements();
  elements.set_bulk_fraction(3, 0.5);
  palpate::test::for_each_simd_target([&](const char* target) {
    const TissueState state = tissue_of_tets(one_thread, c.bodies, elements, c.positions);
    int inverted = 0;
    for (Index e = 0; e < elements.size(); ++e) {
      const auto tet = static_cast<std::size_t>(at(elements.tet_of_element(), e));
      const ElementStress expected = stress_of(elements.deformation(e, c.positions));
      const Eigen::Matrix3d f = to_eigen(Matrix3{state.deformation_gradient[tet]});
      const Eigen::Matrix3d expected_f = to_eigen(expected.deformation_gradient);
      ASSERT_LT((f - expected_f).norm(), 1e-13 * expected_f.norm()) << target << ", " << e;
      ASSERT_NEAR(state.volume_ratio[tet], expected.volume_ratio, 1e-12 * std::pow(expected_f.norm(), 3));
      ASSERT_NEAR(state.energy_density[tet], expected.energy_density, 1e-11 * expected.energy_density);
      const Eigen::Matrix3d strain = to_eigen(expected.strain);
      ASSERT_LT((to_eigen(to_matrix(state.strain[tet])) - strain).norm(), 1e-13 * (1.0 + strain.norm()));
      if (!(expected.volume_ratio > 0.0)) {
        ++inverted;
        ASSERT_TRUE(std::isnan(state.stress[tet].xx) && std::isnan(state.principal_stress[tet].y) &&
                    std::isnan(state.principal_directions[tet][1].z));
        continue;
      }
      const Eigen::Matrix3d stress = to_eigen(expected.stress);
      ASSERT_LT((to_eigen(to_matrix(state.stress[tet])) - stress).norm(), 1e-11 * stress.norm()) << target;
    }
    ASSERT_GT(inverted, 3);
  });
}

/// Equal and nearly equal eigenvalues, zero, large and small numbers, numbers that are not finite.
TEST(SimdTargets, EigenvectorsEqualThoseOfTheTwin) {
  std::mt19937_64 random(33);
  std::vector<SymmetricTensor> tensors(3);
  tensors[1] = {1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
  tensors[2] = {2.0, NAN, 1.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < 400; ++i) {
    const Eigen::Matrix3d q = to_eigen(random_rotation(random));
    const Vec3 v = random_vector(random, 1.0);
    const double spread = i % 3 == 0 ? 1e-9 : 1.0;
    const double size = i % 5 == 0 ? 1e200 : i % 7 == 0 ? 1e-200 : 1e4;
    const Eigen::Vector3d values(1.0 + spread * v.x, 1.0 + spread * v.y, i % 2 == 0 ? -1e6 : v.z);
    const Eigen::Matrix3d m = size * q * values.asDiagonal() * q.transpose();
    tensors.push_back({m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2)});
  }
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<Vec3> values(tensors.size());
    std::vector<std::array<Vec3, 3>> vectors(tensors.size());
    const std::size_t done = simd::symmetric_eigen(tensors, values, vectors);
    ASSERT_TRUE(done == 0 || done == tensors.size() / 8 * 8) << target;
    for (std::size_t i = 0; i < done; ++i) {
      const SymmetricEigen twin = symmetric_eigen(to_matrix(tensors[i]));
      if (std::isnan(twin.values.x)) {
        ASSERT_TRUE(std::isnan(values[i].z) && std::isnan(vectors[i][2].x));
        continue;
      }
      const double size = std::max(std::abs(twin.values.x), std::abs(twin.values.z));
      const double unit = size > 0.0 ? 1.0 / size : 1.0;
      ASSERT_LT(length(unit * values[i] - unit * twin.values), 1e-14) << target << ", " << i;
      Eigen::Matrix3d v;
      for (int k = 0; k < 3; ++k) {
        const Vec3& a = vectors[i][static_cast<std::size_t>(k)];
        v.col(k) = to_eigen(a);
        ASSERT_GT(std::max({a.x, a.y, a.z}), 0.5);  // the largest component is positive
      }
      const Eigen::Matrix3d exact = unit * to_eigen(to_matrix(tensors[i]));
      ASSERT_LT((v * to_eigen(unit * values[i]).asDiagonal() * v.transpose() - exact).norm(), 2e-14) << i;
      ASSERT_LT((v.transpose() * v - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    }
  });
}

TEST(SimdTargets, StiffnessPassEqualsTheBlocks) {
  const ElementCase c;
  Elements elements = c.elements();
  const auto x = random_vectors(c.positions.size(), 1.0, 90);
  palpate::test::for_each_simd_target([&](const char* target) {
    elements.update(one_thread, c.positions);
    const auto products = elements.multiply(one_thread, padded(x));
    std::vector<Vec3> expected(x.size());
    std::vector<double> size(x.size());
    for (Index e = 0; e < elements.size(); ++e) {
      const Tet& corners = at(elements.corners(), e);
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) {
          Matrix3 block;
          elements.add_stiffness(e, i, j, block);
          const Vec3 product = block * at(x, at(corners, j));
          at(expected, at(corners, i)) += product;
          at(size, at(corners, i)) += length(product);
        }
      }
    }
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Vec3 found{products[i].x, products[i].y, products[i].z};
      ASSERT_LT(length(found - expected[i]), 1e-12 * size[i]) << target;
    }
  });
}

std::vector<simd::Quad> random_quads(std::size_t count, unsigned seed) {
  const auto values = random_floats(3 * count, seed);
  std::vector<simd::Quad> quads(count);
  for (std::size_t i = 0; i < count; ++i)
    quads[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2], 0.0F};
  return quads;
}

double distance(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::pow(static_cast<double>(a[i] - b[i]), 2);
  return std::sqrt(sum);
}

double size_of(const std::vector<float>& a) {
  return distance(a, std::vector<float>(a.size(), 0.0F));
}

std::vector<float> flat(const std::vector<simd::Quad>& rows) {
  std::vector<float> values;
  for (const simd::Quad& row : rows) values.insert(values.end(), {row.x, row.y, row.z, row.w});
  return values;
}

struct RowsCase {
  RowsCase() : elements(shapes.elements()), free(shapes.positions.size(), 1), matrix(elements, free) {
    elements.update(one_thread, noisy(shapes.bodies, 0.02, 82));
    std::mt19937_64 random(83);
    std::uniform_real_distribution<double> uniform(0.5, 2.0);
    for (std::size_t i = 0; i < free.size(); ++i) masses.push_back(uniform(random));
    for (std::int32_t c = 0; c < 50; ++c) {
      Coupling coupling;
      coupling.points = {c, c + 3, c % 7 == 0 ? -1 : c + 9, c + 11, c + 5};
      coupling.coefficients = {1.0, -uniform(random), -0.3, 0.2, 0.7};
      coupling.stiffness = {2.0 * uniform(random), uniform(random), 3.0, 0.1, 0.2, 0.3};
      list.push_back(coupling);
    }
    couplings.set(one_thread, list, 0.5, free);
    couplings.order(one_thread, matrix.row_of_point(), matrix.row_count());
  }
  ElementCase shapes;
  Elements elements;
  std::vector<std::uint8_t> free;
  BlockMatrix matrix;
  std::vector<double> masses;
  std::vector<Coupling> list;
  CouplingSystem couplings;
};

TEST(SimdTargets, ProductEqualsItsTwin) {
  RowsCase c;
  const auto x = random_quads(c.matrix.row_count(), 84);
  std::vector<std::vector<float>> results;
  palpate::test::for_each_simd_target([&](const char* target) {
    c.matrix.assemble(one_thread, c.masses);
    c.couplings.multiply(one_thread, x);
    std::vector<float> y(3 * x.size(), 7.0F);
    std::vector<float> twin(3 * x.size(), 7.0F);
    const std::size_t n = c.matrix.slice_count();
    const double inner = simd::multiply_slices(c.matrix.rows(), c.couplings.rows(), x.data(), y.data(), 0, n);
    const double expected =
        simd::scalar::multiply_slices(c.matrix.rows(), c.couplings.rows(), x.data(), twin.data(), 0, n);
    EXPECT_NEAR(inner, expected, 2e-6 * std::abs(expected)) << target;
    EXPECT_LT(distance(y, twin), 2e-6 * size_of(twin)) << target;
    results.push_back(y);
    EXPECT_LT(distance(results.back(), results.front()), 2e-6 * size_of(results.front())) << target;
  });
  EXPECT_GT(size_of(results.front()), 0.0);
}

TEST(SimdTargets, AssemblyEqualsItsTwinWhereRatiosDifferToo) {
  const RowsCase c;
  for (const bool mixed : {false, true}) {
    // Two slices of three slots, with terms of any elements.
    const std::vector<std::uint32_t> slots{0, 2, 3};
    const std::vector<std::uint32_t> begin{0, 3, 4, 9, 11, 14};
    std::vector<std::uint32_t> terms(16 * begin.back());
    std::mt19937_64 random(91);
    for (auto& term : terms) term = static_cast<std::uint32_t>(random() % 1600);
    auto gradients = random_quads(4 * 100, 92);
    for (std::size_t i = 0; i < gradients.size(); ++i)
      gradients[i].w = mixed ? static_cast<float>(1 + i / 4 % 3) : 2.5F;
    const auto masses = random_floats(32, 93);
    const simd::SlicedAssembly rows{slots.data(),     begin.data(),  terms.data(),
                                    gradients.data(), masses.data(), mixed};
    std::vector<float> twin(3 * simd::slot_values);
    std::vector<float> twin_diagonal(2 * simd::slice_symmetric);
    simd::scalar::assemble_slices(rows, twin.data(), twin_diagonal.data(), 0, 2);
    palpate::test::for_each_simd_target([&](const char* target) {
      std::vector<float> values(twin.size());
      std::vector<float> diagonal(twin_diagonal.size());
      simd::assemble_slices(rows, values.data(), diagonal.data(), 0, 2);
      EXPECT_LT(distance(values, twin), 1e-6 * size_of(twin)) << target;
      EXPECT_LT(distance(diagonal, twin_diagonal), 1e-6 * size_of(twin_diagonal));
    });
  }
}

TEST(SimdTargets, InversesOfDiagonalBlocksAreThose) {
  std::vector<float> blocks(2 * simd::slice_symmetric, 0.0F);
  std::mt19937_64 random(94);
  for (std::size_t row = 0; row + 1 < 2 * simd::slice_rows; ++row) {
    const SymmetricMatrix3 a = random_semi_definite(random, row % 3 == 0 ? 1e4 : 1.0);
    const std::array entries{a.xx + 1.0, a.yy + 1.0, a.zz + 1.0, a.xy, a.xz, a.yz};
    for (std::size_t k = 0; k < 6; ++k)
      blocks[simd::slice_symmetric * (row / 16) + 16 * k + row % 16] = static_cast<float>(entries[k]);
  }
  std::vector<float> twin(blocks.size());
  simd::scalar::invert_slices(blocks.data(), twin.data(), 0, 2);
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<float> inverses(blocks.size(), 7.0F);
    simd::invert_slices(blocks.data(), inverses.data(), 0, 2);
    EXPECT_LT(distance(inverses, twin), 1e-3 * size_of(twin)) << target;
    const auto whole = [](const std::vector<float>& v, std::size_t row) {
      const float* p = v.data() + simd::slice_symmetric * (row / 16) + row % 16;
      Eigen::Matrix3f m;
      m << p[0], p[48], p[64], p[48], p[16], p[80], p[64], p[80], p[32];
      return m;
    };
    for (std::size_t row = 0; row + 1 < 32; ++row) {
      const Eigen::Matrix3f product = whole(blocks, row) * whole(inverses, row);
      EXPECT_LT((product - Eigen::Matrix3f::Identity()).norm(), 1e-2F) << target << row;
    }
    EXPECT_EQ(whole(inverses, 31).norm(), 0.0F) << "a row of zeros";
  });
}

TEST(SimdTargets, VectorPassesEqualTheirTwins) {
  constexpr std::size_t n = 5;
  const auto inverse_diagonal = random_floats(simd::slice_symmetric * n, 95);
  const auto masses = random_floats(simd::slice_rows * n, 96, 0.1F);
  const auto inverse_masses = random_floats(simd::slice_rows * n, 97, 0.1F);
  const auto guess = random_floats(simd::slice_values * n, 98);
  struct Vectors {
    std::vector<float> x, r, z, q;
    std::vector<simd::Quad> p;
  };
  const Vectors start{random_floats(simd::slice_values * n, 85), random_floats(simd::slice_values * n, 86),
                      random_floats(simd::slice_values * n, 87), random_floats(simd::slice_values * n, 88),
                      random_quads(simd::slice_rows * n, 89)};
  const auto view = [&](Vectors& v) {
    return simd::GradientVectors{v.x.data(),
                                 v.r.data(),
                                 v.z.data(),
                                 v.q.data(),
                                 v.p.data(),
                                 guess.data(),
                                 inverse_diagonal.data(),
                                 masses.data(),
                                 inverse_masses.data()};
  };
  palpate::test::for_each_simd_target([&](const char* target) {
    Vectors found = start;
    Vectors twin = start;
    const simd::VectorSums sums = simd::advance_slices(view(found), 0.7F, 1, n - 1);
    const simd::VectorSums expected = simd::scalar::advance_slices(view(twin), 0.7F, 1, n - 1);
    EXPECT_NEAR(sums.residual, expected.residual, 1e-6 * expected.residual) << target;
    EXPECT_NEAR(sums.by_mass, expected.by_mass, 1e-6 * expected.by_mass) << target;
    EXPECT_NEAR(sums.solution, expected.solution, 1e-6 * expected.solution) << target;
    EXPECT_NEAR(sums.preconditioned, expected.preconditioned, 1e-6 * expected.residual) << target;
    simd::update_directions(view(found), -0.3F, 1, n - 1);
    simd::scalar::update_directions(view(twin), -0.3F, 1, n - 1);
    EXPECT_LT(distance(found.x, twin.x), 1e-6 * size_of(twin.x)) << target;
    EXPECT_LT(distance(found.r, twin.r), 1e-6 * size_of(twin.r)) << target;
    EXPECT_LT(distance(found.z, twin.z), 1e-6 * size_of(twin.z)) << target;
    EXPECT_LT(distance(flat(found.p), flat(twin.p)), 1e-6 * size_of(flat(twin.p))) << target;
    EXPECT_EQ(found.x[simd::slice_values - 1], start.x[simd::slice_values - 1]) << "outside of the range";
    EXPECT_NE(found.x[simd::slice_values], start.x[simd::slice_values]);
  });
}

}  // namespace
}  // namespace palpate::fem::test

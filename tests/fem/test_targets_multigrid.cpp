// The kernels of multigrid on every SIMD target of this processor, against the same in plain C++.
#include <cmath>
#include <gtest/gtest.h>

#include "fem/block_matrix.hpp"
#include "fem/gauss_seidel.hpp"
#include "fem/meshes.hpp"
#include "fem/system.hpp"
#include "simd/block_products.hpp"
#include "simd/coupling_blocks.hpp"
#include "simd/envelope.hpp"
#include "simd/gauss_seidel.hpp"
#include "simd/padded_rows.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

void expect_near(std::span<const float> found, std::span<const float> expected, const char* target) {
  ASSERT_EQ(found.size(), expected.size());
  double size = 0.0;
  double distance = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    size += std::pow(static_cast<double>(expected[i]), 2);
    distance += std::pow(static_cast<double>(found[i] - expected[i]), 2);
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(distance, 1e-11 * size) << target;
}
void expect_near(std::span<const simd::Quad> found, std::span<const simd::Quad> expected,
                 const char* target) {
  const auto flat = [](std::span<const simd::Quad> quads) {
    std::vector<float> values;
    for (const simd::Quad& q : quads) values.insert(values.end(), {q.x, q.y, q.z});
    return values;
  };
  expect_near(flat(found), flat(expected), target);
}

TEST(SimdTargets, BlockProductsHaveTheBitsOfTheirTwin) {
  constexpr std::uint32_t blocks = 40;
  const auto numbers = [](unsigned seed) {
    const std::vector<float> floats = random_floats(36 * blocks, seed);
    std::vector<double> values;
    for (const float value : floats) values.push_back(static_cast<double>(value) / 3.0);
    return values;
  };
  const std::vector<double> first = numbers(1);
  const std::vector<double> second = numbers(2);
  std::vector<simd::BlockPair> pairs;
  for (std::uint32_t t = 0; t < 200; ++t) pairs.push_back({t * 7 % blocks, t * 11 % blocks, t / 3 % blocks});
  for (const auto kind :
       {simd::BlockProduct::three, simd::BlockProduct::six, simd::BlockProduct::three_transposed,
        simd::BlockProduct::six_transposed, simd::BlockProduct::tall_transposed}) {
    std::vector<double> expected = numbers(3);
    simd::scalar::add_block_products(kind, first.data(), second.data(), pairs.data(), pairs.size(),
                                     expected.data());
    palpate::test::for_each_simd_target([&](const char* target) {
      std::vector<double> found = numbers(3);
      simd::add_block_products(kind, first.data(), second.data(), pairs.data(), pairs.size(), found.data());
      EXPECT_TRUE(found == expected) << target << ", kind " << static_cast<int>(kind);
    });
  }
}

TEST(SimdTargets, SmootherKernelsEqualTheirTwins) {
  System s(1);
  const std::size_t slices = s.matrix.slice_count();
  const auto start = quads_by_row(s, s.random_free_vector(1));
  const auto r = floats_by_row(s, s.random_free_vector(2));
  const auto rotations = random_floats(simd::slot_values * slices, 3);
  s.couplings.multiply(s.threads, start);
  const simd::SmootherRows rows{.rows = s.matrix.rows(),
                                .couplings = s.couplings.rows(),
                                .diagonals = s.matrix.diagonal_blocks().data(),
                                .inverses = s.system.inverse_diagonal().data(),
                                .rotations = rotations.data()};
  const std::vector<std::uint32_t> list(s.matrix.slices_of_color()[1].begin(),
                                        s.matrix.slices_of_color()[1].end());
  auto relaxed = start;
  simd::scalar::relax_slices(rows, r.data(), relaxed.data(), list.data(), list.size());
  std::vector<float> rest(r.size());
  auto earlier = start;  // a sweep from zero that has reached this colour
  std::fill(earlier.begin() + static_cast<std::ptrdiff_t>(simd::slice_rows * list.front()), earlier.end(),
            simd::Quad{});
  auto first = earlier;
  simd::scalar::relax_from_zero(rows, r.data(), first.data(), rest.data(), list.data(), list.size());
  std::vector<simd::Quad> residual(start.size());
  simd::scalar::rotated_residual(rows, rest.data(), start.data(), residual.data(), 0, slices);
  auto added = start;
  simd::scalar::add_rotated(rows, residual.data(), added.data(), 0, slices);
  std::vector<float> values(r.size());
  const double inner = simd::scalar::store_slices(start.data(), r.data(), values.data(), 0, slices);
  int targets = 0;
  palpate::test::for_each_simd_target([&](const char* target) {
    ++targets;
    auto z = start;
    simd::relax_slices(rows, r.data(), z.data(), list.data(), list.size());
    expect_near(z, relaxed, target);
    z = earlier;
    std::vector<float> other_rest(r.size());
    simd::relax_from_zero(rows, r.data(), z.data(), other_rest.data(), list.data(), list.size());
    expect_near(z, first, target);
    expect_near(other_rest, rest, target);
    std::vector<simd::Quad> t(start.size());
    simd::rotated_residual(rows, rest.data(), start.data(), t.data(), 0, slices);
    expect_near(t, residual, target);
    z = start;
    simd::add_rotated(rows, residual.data(), z.data(), 0, slices);
    expect_near(z, added, target);
    std::vector<float> stored(r.size());
    const double sum = simd::store_slices(start.data(), r.data(), stored.data(), 0, slices);
    EXPECT_EQ(stored, values) << target;
    EXPECT_NEAR(sum, inner, 1e-5 * std::abs(inner)) << target;
  });
  EXPECT_GT(targets, 1);
}

/// Half of the matrix is left out, because the forward sweep has solved the rest.
TEST(SimdTargets, ResidualAfterAForwardSweepIsThatOfTheWholeMatrix) {
  System s(1);
  const std::size_t slices = s.matrix.slice_count();
  const auto r = floats_by_row(s, s.random_free_vector(2));
  std::vector<float> rotations(simd::slot_values * slices, 0.0F);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    if (i / simd::slice_rows % 9 % 4 == 0) rotations[i] = 1.0F;
  }
  GaussSeidel smoother(s.matrix);
  smoother.update(s.threads, s.system);
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<simd::Quad> z(s.matrix.row_count());
    smoother.forward(s.threads, s.system, r, z);
    std::vector<float> product(r.size());
    s.system.multiply(s.threads, z, product);
    std::vector<simd::Quad> t(z.size());
    simd::rotated_residual(smoother.rows(s.system, rotations.data()), smoother.rest(), z.data(), t.data(), 0,
                           slices);
    std::vector<float> found(r.size());
    std::vector<float> expected(r.size());
    simd::scalar::store_slices(t.data(), r.data(), found.data(), 0, slices);
    for (std::size_t i = 0; i < r.size(); ++i) expected[i] = r[i] - product[i];
    expect_near(found, expected, target);
  });
}

TEST(SimdTargets, ListedProductsAreThoseOfTheCouplings) {
  System s(1);
  const auto x = quads_by_row(s, s.random_free_vector(4));
  const std::vector<std::uint32_t> list{0, 3, 4, 77, 599};
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<simd::Quad> all(s.list.size());
    simd::coupling_products(s.couplings.terms().data(), x.data(), all.data(), 0, all.size());
    std::vector<simd::Quad> listed(s.list.size());
    simd::listed_products(s.couplings.terms().data(), x.data(), listed.data(), list.data(), list.size());
    for (const std::uint32_t c : list) {
      EXPECT_EQ(listed[c].x, all[c].x) << target;
      EXPECT_EQ(listed[c].z, all[c].z) << target;
    }
    EXPECT_EQ(listed[1].x, 0.0F);
  });
}

TEST(SimdTargets, RotationsEqualTheirTwins) {
  const std::vector<std::uint32_t> slots{0, 1, 2};
  std::vector<std::uint32_t> lanes(32);
  for (std::uint32_t i = 0; i < 32; ++i) lanes[i] = (7 * i + 3) % 32;
  const auto edges = random_floats(2 * simd::slice_values, 112);
  std::vector<simd::Quad> positions(32);
  const auto values = random_floats(96, 115);
  for (std::size_t i = 0; i < 32; ++i) positions[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
  const simd::RotationRows rows{slots.data(), lanes.data(), edges.data()};
  std::vector<float> expected(2 * simd::slot_values);
  simd::scalar::find_rotations(rows, positions.data(), expected.data(), 0, 2);
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<float> found(expected.size());
    simd::find_rotations(rows, positions.data(), found.data(), 0, 2);
    expect_near(found, expected, target);
  });
}

/// Five rows of six by six blocks with different numbers of blocks.
struct PaddedCase {
  std::vector<std::uint32_t> begin{0, 2, 4, 7, 8, 10};
  std::vector<std::uint32_t> columns{1, 4, 0, 2, 1, 3, 4, 2, 0, 2};
  std::vector<std::uint32_t> more_begin{0, 0, 1, 1, 2, 2};
  std::vector<std::uint32_t> more_columns{4, 1};
  simd::AlignedVector<float> blocks = filled(simd::six_by_six * 10, 1);
  simd::AlignedVector<float> more = filled(simd::six_by_six * 2, 2);
  simd::AlignedVector<float> inverses = filled(simd::six_by_six * 5, 3);
  simd::AlignedVector<simd::Six> b = sixes(4);
  simd::AlignedVector<simd::Six> x = sixes(5);

  static simd::AlignedVector<float> filled(std::size_t count, unsigned seed) {
    const auto values = random_floats(count, seed);
    return {values.begin(), values.end()};
  }
  static simd::AlignedVector<simd::Six> sixes(unsigned seed) {
    const auto values = random_floats(40, seed);
    simd::AlignedVector<simd::Six> result(5);
    for (std::size_t i = 0; i < 40; ++i) result[i / 8].values[i % 8] = values[i];
    return result;
  }
  [[nodiscard]] simd::PaddedRows rows() const { return {begin.data(), columns.data(), blocks.data()}; }
  [[nodiscard]] simd::SixMatrix matrix() const {
    return {rows(), {more_begin.data(), more_columns.data(), more.data()}, inverses.data()};
  }
};

std::vector<float> flat(const simd::AlignedVector<simd::Six>& rows) {
  std::vector<float> values;
  for (const simd::Six& row : rows) values.insert(values.end(), row.values.begin(), row.values.end());
  return values;
}

TEST(SimdTargets, KernelsOfCoarseLevelsEqualTheirTwins) {
  const PaddedCase c;
  std::vector<simd::Quad> points(5);
  for (std::size_t i = 0; i < 5; ++i)
    points[i] = {c.b[i].values[0], c.b[i].values[1], c.b[i].values[2], 0.0F};
  const auto all = [&](auto&& gather, auto&& spread, auto&& multiply, auto&& add, auto&& forward,
                       auto&& backward, auto&& onward, auto&& residual) {
    std::vector<std::vector<float>> results;
    auto y = c.x;
    gather(c.rows(), points.data(), y.data(), 1, 5);
    results.push_back(flat(y));
    std::vector<simd::Quad> q(5);
    spread(c.rows(), c.x.data(), q.data(), 0, 5);
    results.emplace_back();
    for (const simd::Quad& v : q) results.back().insert(results.back().end(), {v.x, v.y, v.z, v.w});
    y = c.b;
    multiply(c.rows(), c.x.data(), y.data(), 0, 4);
    results.push_back(flat(y));
    add(c.rows(), c.x.data(), y.data(), 1, 5);
    results.push_back(flat(y));
    y = c.x;
    forward(c.matrix(), c.b.data(), y.data(), 0, 5);
    results.push_back(flat(y));
    backward(c.matrix(), c.b.data(), y.data(), 1, 5);
    results.push_back(flat(y));
    onward(c.matrix(), c.b.data(), y.data(), 0, 4);
    results.push_back(flat(y));
    residual(c.matrix(), c.x.data(), y.data(), 1, 4);
    results.push_back(flat(y));
    return results;
  };
  const auto expected =
      all(simd::scalar::multiply_six_by_three, simd::scalar::multiply_three_by_six,
          simd::scalar::multiply_six, simd::scalar::add_six, simd::scalar::relax_forward,
          simd::scalar::relax_backward, simd::scalar::relax_forward_from, simd::scalar::residual_above);
  palpate::test::for_each_simd_target([&](const char* target) {
    const auto found =
        all(simd::multiply_six_by_three, simd::multiply_three_by_six, simd::multiply_six, simd::add_six,
            simd::relax_forward, simd::relax_backward, simd::relax_forward_from, simd::residual_above);
    for (std::size_t k = 0; k < expected.size(); ++k) expect_near(found[k], expected[k], target);
  });
}

TEST(SimdTargets, BlocksOfCouplingsEqualTheirTwins) {
  const auto random = [](std::size_t count, unsigned seed) {
    const auto values = random_floats(count, seed);
    return simd::AlignedVector<double>(values.begin(), values.end());
  };
  const auto jacobians = random(simd::three_rows * 4, 1);
  const auto transfers = PaddedCase::filled(simd::six_rows * 4, 3);
  const std::vector<simd::BlockTerm> terms{{0, 3, 1, 3}, {2, 0, 1, 1}, {1, 1, 0, 3}, {3, 2, 0, 1}};
  const auto all = [&](auto&& outer, auto&& coarsen) {
    auto blocks = random(simd::six_rows * 2, 4);
    outer(jacobians.data(), terms.data(), terms.size(), blocks.data());
    auto motions = random(simd::three_rows * 2, 5);
    coarsen(jacobians.data(), transfers.data(), terms.data(), terms.size(), motions.data());
    blocks.insert(blocks.end(), motions.begin(), motions.end());
    return blocks;
  };
  const auto expected = all(simd::scalar::add_outer_products, simd::scalar::add_transfers);
  palpate::test::for_each_simd_target([&](const char* target) {
    const auto found = all(simd::add_outer_products, simd::add_transfers);
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (i % simd::row_of_six < 6) {  // not the padding
        EXPECT_NEAR(found[i], expected[i], 1e-14) << target;
      }
    }
  });
}

TEST(SimdTargets, EnvelopeFactorEqualsItsTwin) {
  const std::vector<std::int32_t> first{0, 0, 1, 0, 4, 2, 5};
  std::vector<std::size_t> begin;
  std::size_t count = 0;
  for (std::size_t row = 0; row < first.size(); ++row) {
    begin.push_back(count - static_cast<std::size_t>(first[row]));
    count += row + 1 - static_cast<std::size_t>(first[row]);
  }
  const auto values = random_floats(simd::envelope_block * count, 1);
  const auto right = random_floats(simd::envelope_vector * first.size(), 2);
  const auto all = [&](auto&& factor, auto&& solve) {
    simd::AlignedVector<double> blocks(values.begin(), values.end());
    simd::AlignedVector<double> transposed(blocks.size());
    for (std::size_t row = 0; row < first.size(); ++row) {
      double* diagonal = blocks.data() + simd::envelope_block * (begin[row] + row);
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < i; ++j)
          diagonal[simd::envelope_vector * i + j] = diagonal[simd::envelope_vector * j + i];
        diagonal[(simd::envelope_vector + 1) * i] = 20.0;
      }
    }
    const simd::Envelope a{first.size(), first.data(), begin.data(), blocks.data(), transposed.data()};
    factor(a);
    simd::AlignedVector<double> x(right.begin(), right.end());
    solve(a, x.data());
    std::vector<double> solution;
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (i % simd::envelope_vector < 6) solution.push_back(x[i]);
    }
    return solution;
  };
  const auto expected = all(simd::scalar::factor_envelope, simd::scalar::solve_envelope);
  palpate::test::for_each_simd_target([&](const char* target) {
    const auto found = all(simd::factor_envelope, simd::solve_envelope);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_NEAR(found[i], expected[i], 1e-14) << target;
  });
}

}  // namespace
}  // namespace palpate::fem::test

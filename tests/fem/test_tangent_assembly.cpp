// Sums of stored blocks for the rows of a matrix, on every SIMD target. Oracle: the twin in plain C++, bit by
// bit, since each row adds its terms in their order; sums by Eigen.
#include <Eigen/Dense>
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "simd/aligned.hpp"
#include "simd/element_pass.hpp"
#include "simd/hyperelastic_pass.hpp"
#include "simd/sliced_rows.hpp"
#include "support/simd_targets.hpp"

namespace palpate::simd {
namespace {

constexpr std::size_t stride = 13;  // blocks at places that are no multiple of a vector
constexpr std::size_t block_count = 60;

/// Two slices of three slots. The last block is zero, as the one of padding.
struct Case {
  Case() : terms(slice_rows * begin.back()), blocks(stride * block_count), masses(2 * slice_rows) {
    std::mt19937_64 random(17);
    std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
    for (float& value : blocks) value = uniform(random);
    std::fill(blocks.end() - stride, blocks.end(), 0.0F);
    for (float& value : masses) value = uniform(random);
    for (auto& term : terms) {
      term = static_cast<std::uint32_t>(2 * stride * (random() % block_count));
      if (random() % 2 == 0) ++term;
    }
  }
  [[nodiscard]] TangentAssembly rows() const {
    return {slots.data(), begin.data(), terms.data(), blocks.data()};
  }
  std::vector<std::uint32_t> slots{0, 2, 3};
  std::vector<std::uint32_t> begin{0, 3, 4, 9};
  std::vector<std::uint32_t> terms;
  std::vector<float> blocks;
  std::vector<float> masses;
};

TEST(TangentAssembly, HasTheBitsOfItsTwin) {
  const Case c;
  std::vector<float> twin(3 * slot_values);
  std::vector<float> twin_diagonal(2 * slice_symmetric);
  scalar::assemble_tangent_slices(c.rows(), twin.data(), 0, 2);
  scalar::sum_diagonals(c.slots.data(), twin.data(), c.masses.data(), twin_diagonal.data(), 0, 2);
  palpate::test::for_each_simd_target([&](const char* target) {
    std::vector<float> values(twin.size());
    std::vector<float> diagonal(twin_diagonal.size());
    for (std::size_t slice = 0; slice < 2; ++slice) {
      assemble_tangent_slices(c.rows(), values.data(), slice, slice + 1);
      sum_diagonals(c.slots.data(), values.data(), c.masses.data(), diagonal.data(), slice, slice + 1);
    }
    EXPECT_TRUE(values == twin) << target;
    EXPECT_TRUE(diagonal == twin_diagonal) << target;
  });
}

TEST(TangentAssembly, SumsTheBlocksAndTheirTransposes) {
  const Case c;
  using Block = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  std::vector<float> values(3 * slot_values);
  std::vector<float> diagonal(2 * slice_symmetric);
  assemble_tangent_slices(c.rows(), values.data(), 0, 2);
  sum_diagonals(c.slots.data(), values.data(), c.masses.data(), diagonal.data(), 0, 2);
  for (std::size_t row = 0; row < 2 * slice_rows; ++row) {
    const std::size_t slice = row / slice_rows;
    const std::size_t lane = row % slice_rows;
    Block whole = Block::Zero();
    for (std::uint32_t slot = c.slots[slice]; slot < c.slots[slice + 1]; ++slot) {
      Block sum = Block::Zero();
      for (std::uint32_t t = c.begin[slot]; t < c.begin[slot + 1]; ++t) {
        const std::uint32_t term = c.terms[slice_rows * t + lane];
        const Block stored = Eigen::Map<const Block>(c.blocks.data() + term / 2);
        sum += term % 2 == 0 ? stored : Block(stored.transpose());
      }
      for (std::size_t k = 0; k < 9; ++k) {
        EXPECT_NEAR(values[slot_values * slot + slice_rows * k + lane],
                    sum(static_cast<Eigen::Index>(k / 3), static_cast<Eigen::Index>(k % 3)), 1e-6);
      }
      whole += sum;
    }
    const float* own = diagonal.data() + slice_symmetric * slice + lane;
    EXPECT_NEAR(own[0], c.masses[row] - whole(0, 0), 1e-5);
    EXPECT_NEAR(own[2 * slice_rows], c.masses[row] - whole(2, 2), 1e-5);
    EXPECT_NEAR(own[4 * slice_rows], -whole(0, 2), 1e-5);
  }
}

/// Elements from one that begins no group on, and one lane left over.
TEST(TangentPass, HasTheBitsOfItsTwin) {
  constexpr std::size_t first = 5;
  constexpr std::size_t last = 49;
  constexpr std::size_t padded = 64;
  std::mt19937_64 random(18);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Padded3> vectors(40);
  for (Padded3& v : vectors) v = {uniform(random), uniform(random), uniform(random), 0.0};
  std::vector<std::int32_t> corners(4 * padded);
  for (auto& corner : corners) corner = static_cast<std::int32_t>(random() % vectors.size());
  AlignedVector<float> blocks(block_stride * (padded - first + 3));
  for (float& value : blocks) value = static_cast<float>(uniform(random));
  AlignedVector<double> twin(16 * padded);
  const auto pass = [&](AlignedVector<double>& products) -> TangentPass {
    return {vectors.data(), corners.data(), blocks.data(), products.data() + 16 * first};
  };
  scalar::tangent_pass(pass(twin), first, last);
  palpate::test::for_each_simd_target([&](const char* target) {
    AlignedVector<double> products(16 * padded);
    tangent_pass(pass(products), first, last);
    EXPECT_TRUE(std::equal(twin.begin(), twin.begin() + 16 * last, products.begin())) << target;
  });
}

}  // namespace
}  // namespace palpate::simd

// The kernels of the dynamics write and return the same bits on every SIMD target with fused multiply-adds,
// whatever the number of lanes. Oracle: equality. test_targets.cpp checks that the numbers are right.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "fem/block_matrix.hpp"
#include "fem/coupling.hpp"
#include "fem/meshes.hpp"
#include "fem/multigrid.hpp"
#include "fem/system.hpp"
#include "simd/corner_sums.hpp"
#include "simd/sliced_rows.hpp"
#include "support/simd_targets.hpp"

namespace palpate::fem::test {
namespace {

/// The bytes of all results of a kernel.
class Bytes {
 public:
  template <class T>
  void add(std::span<const T> values) {
    text_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::span<const T>(values));
  }
  void add(double value) { add(std::span<const double>(&value, 1)); }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  std::string text_;
};

/// Fails if the results of `work` differ between targets.
template <class Work>
void expect_same_bits(Work&& work) {
  std::string expected;
  palpate::test::for_each_simd_target(palpate::test::targets_of_same_bits(), [&](const char* target) {
    Bytes bytes;
    work(bytes);
    if (expected.empty()) expected = bytes.text();
    ASSERT_FALSE(expected.empty());
    EXPECT_TRUE(bytes.text() == expected) << target;
  });
}

class Floats {
 public:
  explicit Floats(unsigned seed) : random_(seed) {}
  std::vector<float> operator()(std::size_t count, float low = -1.0F) {
    std::uniform_real_distribution<float> uniform(low, 1.0F);
    std::vector<float> values(count);
    for (float& value : values) value = uniform(random_);
    return values;
  }
  std::vector<simd::Quad> quads(std::size_t count) {
    const std::vector<float> values = (*this)(3 * count);
    std::vector<simd::Quad> quads(count);
    for (std::size_t i = 0; i < count; ++i)
      quads[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2], 0.0F};
    return quads;
  }

 private:
  std::mt19937_64 random_;
};

/// Elements nearly at rest beside strained ones, whose rotations need more iterations, and inverted ones.
struct StrainedBody {
  StrainedBody()
      : bodies(single_body(irregular_box_mesh({6, 5, 4}, {0.6, 0.5, 0.4}, 0.2))),
        positions(noisy(bodies, 0.001, 1)),
        elements(bodies, std::vector<Material>(1, {5e4, 0.4, 1000.0, 0.0, 0.0}),
                 std::vector<std::uint8_t>(1, 0)) {
    std::mt19937_64 random(2);
    const Matrix3 rotation = random_rotation(random);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (i % 5 == 0) positions[i] += random_vector(random, i % 25 == 0 ? 0.2 : 0.03);
      positions[i] = rotation * positions[i];
    }
    std::vector<double> factors;
    for (Index e = 0; e < elements.size(); ++e) factors.push_back(1e-4 * (1 + e % 5));
    elements.set_factors(factors);
  }
  Bodies bodies;
  std::vector<Vec3> positions;
  Elements elements;
};

void add_elements(const Elements& elements, Bytes& bytes) {
  bytes.add(elements.point_forces());
  bytes.add(elements.gradients());
  for (Index e = 0; e < elements.size(); ++e) {
    bytes.add(elements.energy(e));
    bytes.add(elements.inverted(e) ? 1.0 : 0.0);
    for (int corner = 0; corner < 4; ++corner) {
      const Vec3 gradient = elements.gradient(e, corner);
      bytes.add(std::span(&gradient, 1));
    }
  }
}

TEST(SameBits, Elements) {
  StrainedBody body;
  const auto x = padded(random_vectors(body.positions.size(), 1.0, 3));
  expect_same_bits([&](Bytes& bytes) {
    body.elements.update(one_thread, body.positions);
    add_elements(body.elements, bytes);
    bytes.add(body.elements.multiply(one_thread, x));
  });
  int inverted = 0;
  for (Index e = 0; e < body.elements.size(); ++e) inverted += body.elements.inverted(e) ? 1 : 0;
  EXPECT_GT(inverted, 5);
  EXPECT_LT(inverted, body.elements.size() / 2);
}

TEST(SameBits, Assembly) {
  for (const bool mixed : {false, true}) {
    Floats floats(4);
    const std::vector<std::uint32_t> slots{0, 2, 3};
    const std::vector<std::uint32_t> begin{0, 3, 4, 9};
    std::vector<std::uint32_t> terms(16 * begin.back());
    for (std::size_t i = 0; i < terms.size(); ++i) terms[i] = static_cast<std::uint32_t>(701 * i % 1600);
    auto gradients = floats.quads(4 * 100);
    for (std::size_t i = 0; i < gradients.size(); ++i)
      gradients[i].w = mixed ? static_cast<float>(1 + i / 4 % 3) : 2.5F;
    const auto masses = floats(32);
    const simd::SlicedAssembly rows{slots.data(),     begin.data(),  terms.data(),
                                    gradients.data(), masses.data(), mixed};
    expect_same_bits([&](Bytes& bytes) {
      std::vector<float> values(3 * simd::slot_values);
      std::vector<float> diagonal(2 * simd::slice_symmetric);
      simd::assemble_slices(rows, values.data(), diagonal.data(), 0, 2);
      bytes.add(values);
      bytes.add(diagonal);
    });
  }
}

/// Scales so different that a sum of squares in double depends on its order.
float size_of_row(std::size_t row) {
  return std::ldexp(1.0F, static_cast<int>(row * 7 % 61) - 30);
}

TEST(SameBits, ProductWithCouplings) {
  StrainedBody body;
  body.elements.update(one_thread, body.positions);
  const std::vector<std::uint8_t> free(body.positions.size(), 1);
  BlockMatrix matrix(body.elements, free);
  matrix.assemble(one_thread, std::vector<double>(free.size(), 0.7));
  std::vector<Coupling> list;
  for (std::int32_t c = 0; c < 60; ++c) {
    Coupling coupling;
    coupling.points = {c, c + 3, c % 7 == 0 ? -1 : c + 9, c + 11, c + 5};
    coupling.coefficients = {1.0, -0.3, -0.3, 0.2 + 0.01 * c, 0.7};
    coupling.stiffness = {2.0 + c, 1.0, 3.0, 0.1, 0.2, 0.3};
    list.push_back(coupling);
  }
  CouplingSystem couplings;
  couplings.set(one_thread, list, 0.5, free);
  couplings.order(one_thread, matrix.row_of_point(), matrix.row_count());
  const std::size_t slices = matrix.slice_count();
  auto x = Floats(5).quads(simd::slice_rows * slices);
  for (std::size_t i = 0; i < x.size(); ++i)
    x[i] = {size_of_row(i) * x[i].x, size_of_row(i) * x[i].y, size_of_row(i) * x[i].z, 0.0F};
  ASSERT_GE(slices, 8U);
  expect_same_bits([&](Bytes& bytes) {
    couplings.multiply(one_thread, x);
    std::vector<float> y(simd::slice_values * slices);
    for (const auto& [first, last] : {std::pair<std::size_t, std::size_t>{0, slices}, {1, 2}, {2, 7}}) {
      bytes.add(simd::multiply_slices(matrix.rows(), couplings.rows(), x.data(), y.data(), first, last));
    }
    bytes.add(y);
  });
}

/// A whole cycle of multigrid, with its set-up: couplings of several nodes on each level, and the factor.
TEST(SameBits, MultigridCycle) {
  System s(1);
  const auto positions = noisy(s.bodies, 0.02, 20);
  const auto r = floats_by_row(s, s.random_free_vector(8));
  expect_same_bits([&](Bytes& bytes) {
    Multigrid multigrid(s.matrix);
    multigrid.update(s.threads, s.system, positions);
    std::vector<float> z(r.size());
    bytes.add(multigrid.apply(s.threads, s.system, r, z));
    bytes.add(z);
  });
}

TEST(SameBits, InversesOfDiagonalBlocks) {
  std::mt19937_64 random(6);
  std::vector<float> blocks(2 * simd::slice_symmetric, 0.0F);
  for (std::size_t row = 0; row + 1 < 2 * simd::slice_rows; ++row) {
    const Vec3 a = random_vector(random, row % 3 == 0 ? 1e4 : 1.0);
    const std::array entries{a.x * a.x + 1.0, a.y * a.y + 1.0, a.z * a.z + 1.0,
                             a.x * a.y,       a.x * a.z,       a.y * a.z};
    for (std::size_t k = 0; k < 6; ++k)
      blocks[simd::slice_symmetric * (row / 16) + 16 * k + row % 16] = static_cast<float>(entries[k]);
  }
  expect_same_bits([&](Bytes& bytes) {
    std::vector<float> inverses(blocks.size(), 7.0F);
    simd::invert_slices(blocks.data(), inverses.data(), 0, 2);
    bytes.add(inverses);
  });
}

TEST(SameBits, VectorsOfConjugateGradients) {
  constexpr std::size_t n = 9;
  Floats floats(7);
  const auto inverse_diagonal = floats(simd::slice_symmetric * n);
  const auto masses = floats(simd::slice_rows * n, 0.1F);
  const auto inverse_masses = floats(simd::slice_rows * n, 0.1F);
  const auto guess = floats(simd::slice_values * n);
  const auto x0 = floats(simd::slice_values * n);
  const auto r0 = floats(simd::slice_values * n);
  const auto q = floats(simd::slice_values * n);
  const auto p0 = floats.quads(simd::slice_rows * n);
  expect_same_bits([&](Bytes& bytes) {
    auto x = x0;
    auto r = r0;
    for (std::size_t i = 0; i < r.size(); ++i) r[i] *= size_of_row(i);
    auto product = q;
    auto p = p0;
    std::vector<float> z(x.size());
    const simd::GradientVectors vectors{x.data(),
                                        r.data(),
                                        z.data(),
                                        product.data(),
                                        p.data(),
                                        guess.data(),
                                        inverse_diagonal.data(),
                                        masses.data(),
                                        inverse_masses.data()};
    for (const auto& [first, last] : {std::pair<std::size_t, std::size_t>{0, n}, {3, 4}, {2, 8}}) {
      const simd::VectorSums sums = simd::advance_slices(vectors, 0.7F, first, last);
      for (const double sum : {sums.residual, sums.by_mass, sums.preconditioned, sums.solution})
        bytes.add(sum);
    }
    simd::update_directions(vectors, -0.3F, 1, n);
    for (const auto* vector : {&x, &r, &z}) bytes.add(*vector);
    bytes.add(p);
  });
}

TEST(SameBits, SumsOfCorners) {
  constexpr std::size_t elements = 50;
  const auto values = Floats(8)(16 * elements);
  const std::vector<double> doubles(values.begin(), values.end());
  std::vector<std::uint16_t> places(4 * elements);
  for (std::size_t c = 0; c < places.size(); ++c) places[c] = static_cast<std::uint16_t>(37 * c % 11);
  expect_same_bits([&](Bytes& bytes) {
    std::vector<simd::Padded3> sums(11);
    simd::add_corners(doubles.data(), places.data(), elements, sums.data());
    bytes.add(sums);
  });
}

}  // namespace
}  // namespace palpate::fem::test

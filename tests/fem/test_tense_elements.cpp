// Corotational tissue under tension. Oracles: the derivative of the forces by differences; and Hooke's law of
// a stretched strap, which comes to rest with that energy.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr double young_modulus = 1e6;
constexpr double poisson_ratio = 0.3;

/// A bar of 4 x 2 x 2 cells, stretched by these factors and rotated.
struct StretchedBar {
  explicit StretchedBar(const Vec3& factors, double time_step = 0.0)
      : bodies(single_body(irregular_box_mesh({4, 2, 2}, {0.04, 0.02, 0.02}, 0.2))),
        elements(bodies, std::vector<Material>{{young_modulus, poisson_ratio}},
                 std::vector<std::uint8_t>{0}) {
    for (const Vec3& p : bodies.points_rest()) {
      positions.push_back(
          palpate::test::rotated({factors.x * p.x, factors.y * p.y, factors.z * p.z}, {1, 2, 3}, 0.7));
    }
    if (time_step > 0.0) elements.set_time_step(time_step);
    elements.update(one_thread, positions);
  }
  [[nodiscard]] std::vector<Vec3> forces_at(std::span<const Vec3> directions, double by) {
    std::vector<Vec3> moved = positions;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += by * directions[i];
    elements.update(one_thread, moved);
    return point_forces(elements);
  }

  Bodies bodies;
  Elements elements;
  std::vector<Vec3> positions;
};

std::vector<Vec3> directions_of(const StretchedBar& bar) {
  return random_vectors(bar.positions.size(), 1.0, 5);
}

/// |K' d + df / dx d| of a bar.
double error_of_stiffness(StretchedBar& bar) {
  const std::vector<Vec3> directions = directions_of(bar);
  const std::vector<Vec3> sums = unpadded(bar.elements.multiply(one_thread, padded(directions)));
  constexpr double step = 1e-7;
  const std::vector<Vec3> after = bar.forces_at(directions, step);
  const std::vector<Vec3> before = bar.forces_at(directions, -step);
  double sum = 0.0;
  for (std::size_t i = 0; i < sums.size(); ++i)
    sum += squared_length(sums[i] + 1.0 / (2.0 * step) * (after[i] - before[i]));
  return std::sqrt(sum);
}

/// With all stresses positive, only the stretches in M are left out.
TEST(TenseElements, GeometricStiffnessIsTheRestOfTheDerivative) {
  for (const Vec3& factors : {Vec3{1.02, 1.02, 1.02}, Vec3{1.03, 1.01, 1.01}, Vec3{1.02, 1.02, 0.995}}) {
    StretchedBar without(factors);
    StretchedBar with(factors, 1e3);
    ASSERT_EQ(without.elements.tense().all().size(), 0U);
    ASSERT_EQ(with.elements.tense().all().size(), static_cast<std::size_t>(with.elements.size()));
    EXPECT_LT(error_of_stiffness(with), 0.05 * error_of_stiffness(without)) << factors.x;
  }
}

TEST(TenseElements, UnderPressureThereAreNone) {
  const StretchedBar bar({0.9, 0.9, 0.9}, 1e3);
  EXPECT_TRUE(bar.elements.tense().all().empty());
}

/// Tension counts from the thickness times sqrt(E rho) over the time step on.
TEST(TenseElements, AreThoseWhoseTensionMattersInTheStep) {
  constexpr double strain = 0.02;
  const Bodies bodies = single_body(box_mesh({6, 3, 1}, {0.06, 0.03, 0.01}));
  const std::vector<double> thickness = tissue_thickness(bodies);
  const double wave = std::sqrt(1000.0 * young_modulus);
  Elements elements(bodies, std::vector<Material>{{young_modulus, 0.0, 1000.0}},
                    std::vector<std::uint8_t>{0});
  std::vector<Vec3> positions(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : positions) p.x *= 1.0 + strain;
  for (const double time_step : {0.0005, 0.01, 0.02, 0.03, 0.06, 0.2}) {
    elements.set_time_step(time_step);
    elements.update(one_thread, positions);
    std::size_t expected = 0;
    for (const double d : thickness) expected += strain * young_modulus * time_step > d * wave ? 1 : 0;
    EXPECT_EQ(elements.tense().all().size(), expected) << time_step;
  }
  EXPECT_EQ(elements.tense().all().size(), static_cast<std::size_t>(elements.size()));
}

/// The float matrix, and the product of single elements, have the same geometric stiffness.
TEST(TenseElements, TheMatrixAndItsExactProductsAgree) {
  StretchedBar bar({1.1, 1.05, 0.99}, 1e3);
  const std::size_t n = bar.positions.size();
  BlockMatrix matrix(bar.elements, std::vector<std::uint8_t>(n, 1));
  bar.elements.update(one_thread, bar.positions);
  ASSERT_FALSE(bar.elements.tense().all().empty());
  matrix.assemble(one_thread, std::vector<double>(n, 1.0));
  const std::vector<Vec3> directions = directions_of(bar);
  const std::vector<Vec3> exact = unpadded(bar.elements.multiply(one_thread, padded(directions)));
  std::vector<Vec3> by_elements(n);
  for (Index e = 0; e < bar.elements.size(); ++e) {
    const Tet& corners = at(bar.elements.corners(), e);
    std::array<Vec3, 4> own;
    for (std::size_t k = 0; k < 4; ++k) own[k] = at(directions, corners[k]);
    const std::array<Vec3, 4> products = bar.elements.multiply(e, own);
    for (std::size_t k = 0; k < 4; ++k) at(by_elements, corners[k]) += products[k];
  }
  for (Index point = 0; point < static_cast<Index>(n); ++point) {
    Vec3 sum = -1.0 * at(directions, point);  // the diagonal
    const auto columns = matrix.columns(point);
    for (std::size_t place = 0; place < columns.size(); ++place) {
      sum += matrix.block(point, place) * at(directions, static_cast<Index>(columns[place]));
      const Matrix3 other = [&] {
        const auto back = matrix.columns(static_cast<Index>(columns[place]));
        const auto own = std::ranges::find(back, static_cast<std::uint32_t>(point)) - back.begin();
        return matrix.block(static_cast<Index>(columns[place]), static_cast<std::size_t>(own));
      }();
      EXPECT_EQ(matrix.block(point, place), transposed(other));
    }
    EXPECT_LT(length(sum - at(exact, point)), 1e-5 * largest(exact));
  }
  EXPECT_LT(largest_distance(by_elements, exact), 1e-12 * largest(exact));
}

/// Layers of tets on a sheet: the thickness is right within a factor of two.
TEST(TenseElements, ThicknessCountsLayers) {
  for (const int layers : {1, 2, 3, 4, 6}) {
    const double true_thickness = 0.004 * layers;
    const Bodies bodies = single_body(box_mesh({12, 12, layers}, {0.048, 0.048, true_thickness}));
    const std::vector<double> thickness = tissue_thickness(bodies);
    // Inside, away from the border, where layers are all that counts.
    for (std::size_t t = 0; t < thickness.size(); ++t) {
      bool inside = true;
      for (const Index corner : bodies.tets()[t]) {
        const Vec3& p = at(bodies.points_rest(), corner);
        inside = inside && std::min({p.x, p.y, 0.048 - p.x, 0.048 - p.y}) > 0.5 * true_thickness + 0.004;
      }
      if (!inside) continue;
      EXPECT_GT(thickness[t], 0.5 * true_thickness) << layers;
      EXPECT_LT(thickness[t], 2.0 * true_thickness) << layers;
    }
  }
}

/// A strap between two ends, of which one moves away for 0.2 s. Without its geometric stiffness it vibrated
/// without end, with up to 45 times the energy.
void expect_hookes_energy(const std::array<int, 3>& cells, const Vec3& size, double modulus, double strain,
                          double time_step) {
  const Bodies bodies = single_body(box_mesh(cells, size));
  std::vector<Index> pulled;
  for (Index p = 0; p < static_cast<Index>(bodies.points_rest().size()); ++p)
    if (at(bodies.points_rest(), p).x > 0.999 * size.x) pulled.push_back(p);
  const auto held = select(bodies, [&](const Vec3& p) { return p.x == 0.0 || p.x > 0.999 * size.x; });
  Dynamics dynamics = Scene{{modulus, 0.0, 1000.0}, held, 1}.dynamics(bodies);
  const int steps = static_cast<int>(std::lround(1.0 / time_step));
  for (int n = 1; n <= steps; ++n) {
    std::vector<Vec3> ends;
    for (const Index p : pulled) {
      ends.push_back(at(bodies.points_rest(), p) +
                     Vec3{strain * size.x * std::min(1.0, n * time_step / 0.2), 0.0, 0.0});
    }
    dynamics.prescribe(pulled, ends);
    dynamics.step(time_step, {}, {}, {}, 1e-4, 1000);
  }
  const double expected = 0.5 * modulus * strain * strain * size.x * size.y * size.z;
  EXPECT_NEAR(dynamics.elastic_energy(), expected, 1e-3 * expected) << time_step << " s";
  EXPECT_LT(dynamics.kinetic_energy(), 1e-6 * expected) << time_step << " s";
}

TEST(TenseElements, AStretchedStrapComesToRest) {
  for (const double time_step : {0.02, 0.01, 0.002}) {
    expect_hookes_energy({20, 2, 1}, {0.1, 0.006, 0.002}, 1.2e9, 0.025, time_step);
    expect_hookes_energy({20, 4, 2}, {0.1, 0.01, 0.002}, 1e7, 0.1, time_step);
    expect_hookes_energy({12, 12, 1}, {0.2, 0.2, 0.002}, 1e6, 0.1, time_step);
    expect_hookes_energy({10, 3, 3}, {0.2, 0.03, 0.03}, 1e6, 0.4, time_step);
  }
}

}  // namespace
}  // namespace palpate::fem::test

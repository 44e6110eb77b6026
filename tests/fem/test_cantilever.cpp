#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "fem/tissue.hpp"

namespace palpate::fem::test {
namespace {

constexpr double beam_length = 1.0;
constexpr double height = 0.2;  // along z, the direction of bending
constexpr double width = 0.1;
constexpr double load = 1e-4;
constexpr double young_modulus = 1e5;

/// Tip deflection of a clamped beam under a load at its end (Timoshenko): P L^3 / (3 E I) + P L / (kappa G
/// A), with Cowper's kappa for a rectangle ("The shear coefficient in Timoshenko's beam theory", J. Appl.
/// Mech. 33 (1966)).
double beam_theory(double poisson_ratio) {
  const double area = width * height;
  const double inertia = width * std::pow(height, 3) / 12.0;
  const double shear_modulus = young_modulus / (2.0 * (1.0 + poisson_ratio));
  const double kappa = 10.0 * (1.0 + poisson_ratio) / (12.0 + 11.0 * poisson_ratio);
  return load * std::pow(beam_length, 3) / (3.0 * young_modulus * inertia) +
         load * beam_length / (kappa * shear_modulus * area);
}

/// A beam that is clamped at x = 0 and bent by a load at its end.
struct Beam {
  Beam(const std::array<int, 3>& cells, double poisson_ratio)
      : bodies(single_body(box_mesh(cells, {beam_length, width, height}))),
        material{young_modulus, poisson_ratio, 1000.0, 0.0, 0.0},
        dynamics(
            Scene{material, select(bodies, [](const Vec3& p) { return p.x == 0.0; }), 2}.dynamics(bodies)) {}
  Bodies bodies;
  Material material;
  Dynamics dynamics;
  double deflection();
};

/// Mean deflection of the end.
double Beam::deflection() {
  const auto tip = select(bodies, [](const Vec3& p) { return p.x == beam_length; });
  double total = 0.0;
  std::vector<Vec3> forces(tip.size());
  const auto rest = bodies.points_rest();
  // Trapezoidal weights: half at the sides of the end, a quarter at its corners.
  const auto weight = [&](std::size_t i) {
    if (tip[i] == 0) return 0.0;
    const bool side_y = rest[i].y == 0.0 || rest[i].y == width;
    const bool side_z = rest[i].z == 0.0 || rest[i].z == height;
    return (side_y ? 0.5 : 1.0) * (side_z ? 0.5 : 1.0);
  };
  for (std::size_t i = 0; i < tip.size(); ++i) total += weight(i);
  for (std::size_t i = 0; i < tip.size(); ++i) forces[i].z = -load * weight(i) / total;
  settle(dynamics, forces, 1, 1e-8, 20000);
  double sum = 0.0;
  for (std::size_t i = 0; i < tip.size(); ++i) {
    sum += weight(i) / total * (rest[i].z - dynamics.positions()[i].z);
  }
  EXPECT_LT(sum, 1e-3 * beam_length) << "not a small deflection";
  return sum;
}

/// Deflection over that of beam theory.
double deflection_ratio(const std::array<int, 3>& cells, double poisson_ratio) {
  const double deflection = Beam(cells, poisson_ratio).deflection();
  std::printf("%dx%dx%d nu %.1f: %.4f of beam theory\n", cells[0], cells[1], cells[2], poisson_ratio,
              deflection / beam_theory(poisson_ratio));
  return deflection / beam_theory(poisson_ratio);
}

void expect_within_five_percent_and_converging(double poisson_ratio) {
  const double coarse = 1.0 - deflection_ratio({15, 2, 3}, poisson_ratio);
  const double middle = 1.0 - deflection_ratio({30, 3, 6}, poisson_ratio);
  const double fine = 1.0 - deflection_ratio({60, 6, 12}, poisson_ratio);
  EXPECT_LT(std::abs(fine), 0.05);
  // Linear tets are too stiff in bending, with an error of the square of the cell size.
  EXPECT_GT(fine, -0.01);
  EXPECT_LT(middle, 0.5 * coarse);
  EXPECT_LT(fine, 0.5 * middle);
}

TEST(Cantilever, MatchesBeamTheoryWithoutLateralContraction) {
  expect_within_five_percent_and_converging(0.0);
}
TEST(Cantilever, MatchesBeamTheoryAtPoissonRatio03) {
  expect_within_five_percent_and_converging(0.3);
}

/// Error of the recovered stress along the top of the beam against M(x) z / I, relative to its largest value,
/// root mean square over the points from a quarter to three quarters of the length.
double bending_stress_error(const std::array<int, 3>& cells) {
  Beam beam(cells, 0.3);
  beam.deflection();
  const parallel::Threads threads(2);
  const TissueState tets =
      tissue_of_tets(threads, beam.bodies, beam.dynamics.elements(), beam.dynamics.positions());
  const TissueState points =
      tissue_of_points(threads, beam.bodies, beam.dynamics.elements(), Materials{beam.material}, tets);
  const double inertia = width * std::pow(height, 3) / 12.0;
  const double largest = load * beam_length * 0.5 * height / inertia;
  double squares = 0.0;
  double count = 0.0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const Vec3& rest = beam.bodies.points_rest()[p];
    if (rest.z < height - 1e-9 || rest.x < 0.25 * beam_length || rest.x > 0.75 * beam_length) continue;
    const double theory = load * (beam_length - rest.x) * 0.5 * height / inertia;
    squares += std::pow((points.stress[p].xx - theory) / largest, 2);
    count += 1.0;
  }
  const double error = std::sqrt(squares / count);
  std::printf("%dx%dx%d: error of the bending stress %.4f\n", cells[0], cells[1], cells[2], error);
  return error;
}

TEST(CantileverStress, ConvergesToThatOfBeamTheoryAlongTheBeam) {
  const double coarse = bending_stress_error({15, 2, 3});
  const double middle = bending_stress_error({30, 3, 6});
  const double fine = bending_stress_error({60, 6, 12});
  // The mean over the tets at a surface point is the stress a fraction of a cell below it: first order.
  EXPECT_LT(middle, 0.7 * coarse);
  EXPECT_LT(fine, 0.7 * middle);
  EXPECT_LT(fine, 0.06);
}

}  // namespace
}  // namespace palpate::fem::test

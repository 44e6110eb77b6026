// Large strains of an inflated thick sphere and a twisted cylinder. Oracles: the energy minimised in one
// dimension (radial.hpp), and closed forms in the limit nu = 1/2.
#include <array>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "fem/meshes.hpp"
#include "fem/radial.hpp"
#include "fem/round_meshes.hpp"

namespace palpate::fem::test {
namespace {

constexpr double inner = 0.5;
constexpr double outer = 1.0;
constexpr double pi = 3.14159265358979323846;

Material tissue(MaterialModel model, double nu) {
  return {.young_modulus = 2e4, .poisson_ratio = nu, .density = 1.0, .model = model};
}

Matrix diagonal(Real a, Real b, Real c) {
  Matrix f = Matrix::Zero();
  f(0, 0) = a;
  f(1, 1) = b;
  f(2, 2) = c;
  return f;
}

/// A thick sphere whose inner radius becomes `a`.
RadialSolution sphere(const Material& m, double a, int elements) {
  const auto energy_of = [&](Real radius, Real r, Real slope) {
    return 4 * Real(pi) * radius * radius * energy(m, diagonal(slope, r / radius, r / radius), 0);
  };
  const double more = a * a * a - inner * inner * inner;
  return RadialProblem(energy_of, inner, outer, elements)
      .solve([&](double radius) { return std::cbrt(radius * radius * radius + more); }, true);
}

/// Pressure of an incompressible sphere: integral of W'(s) / (s^3 - 1) with s = r/R (Green & Zerna 1954).
double incompressible_pressure(const Material& m, double a) {
  const double b = std::cbrt(outer * outer * outer + a * a * a - inner * inner * inner);
  const Real from = b / outer;
  const Real to = a / inner;
  constexpr int n = 2000;
  Real sum = 0;
  for (int i = 0; i < n; ++i) {
    const Real s = from + (to - from) * (Real(i) + Real(0.5)) / n;
    const Real d = 1e-4L;
    const auto w = [&](Real x) { return energy(m, diagonal(1 / (x * x), x, x), 0); };
    sum += (8 * (w(s + d) - w(s - d)) - (w(s + 2 * d) - w(s - 2 * d))) / (12 * d) / (s * s * s - 1);
  }
  return static_cast<double>(sum * (to - from) / n);
}

TEST(LargeStrain, TheReferenceOfTheSphereHasTheClosedFormAsItsLimit) {
  for (const MaterialModel model : {MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    const Material m = tissue(model, 0.499999);
    const double a = 1.5 * inner;
    const RadialSolution s = sphere(m, a, 400);
    const double pressure = -s.inner_force / (4.0 * pi * a * a);
    EXPECT_NEAR(std::abs(pressure) / incompressible_pressure(m, a), 1.0, 2e-3);
    EXPECT_NEAR(s.at(outer), std::cbrt(1.0 + a * a * a - inner * inner * inner), 1e-4);
  }
}

struct Errors {
  double displacement = 0.0;  ///< of the outer radius, relative to its motion
  double force = 0.0;         ///< that holds the inner radius
};

/// Positions and holding forces at static equilibrium, with the held points where `place` has them.
struct Equilibrium {
  std::vector<Vec3> positions;
  std::vector<Vec3> forces;
};
Equilibrium equilibrium(const Bodies& bodies, const Materials& materials,
                        const std::vector<std::uint8_t>& held,
                        const std::function<Vec3(const Vec3&)>& place) {
  Dynamics dynamics(bodies, materials, held, std::vector<std::uint8_t>(1, 0), parallel::Threads(1));
  dynamics.set_positions(mapped(bodies, place));
  settle(dynamics, {}, 5, 1e-6, 4000);
  Elements elements(bodies, materials, std::vector<std::uint8_t>(1, 0));
  elements.update(parallel::Threads(1), dynamics.positions());
  Equilibrium found{{dynamics.positions().begin(), dynamics.positions().end()}, point_forces(elements)};
  double rest = 0.0;
  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i] == 0) rest = std::max(rest, length(found.forces[i]));
  EXPECT_LT(rest, 1e-6 * largest(found.forces));
  return found;
}

Errors sphere_errors(const Material& m, int n, int layers) {
  constexpr double a = 1.3 * inner;
  const Bodies bodies = single_body(shell_mesh(n, layers, inner, outer));
  const RadialSolution expected = sphere(m, a, 300);
  const auto rest = bodies.points_rest();
  const auto held = select(bodies, [](const Vec3& p) { return length(p) < inner + 1e-9; });
  const Equilibrium found =
      equilibrium(bodies, {m}, held, [&](const Vec3& p) { return (expected.at(length(p)) / length(p)) * p; });
  double force = 0.0;
  double displacement = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (held[i] != 0) force -= dot(found.forces[i], normalized(rest[i]));
    if (length(rest[i]) < outer - 1e-9) continue;
    displacement += length(found.positions[i]) - outer;
    ++count;
  }
  return {displacement / count / (expected.at(outer) - outer) - 1.0, force / expected.inner_force - 1.0};
}

/// Linear tets lock towards nu = 1/2: errors are due to the element, and fall with its size.
TEST(LargeStrain, AThickSphereBlownUpBy30Percent) {
  for (const Material& m :
       {tissue(MaterialModel::stable_neo_hookean, 0.45), tissue(MaterialModel::stable_neo_hookean, 0.49),
        tissue(MaterialModel::mooney_rivlin, 0.45)}) {
    const Errors coarse = sphere_errors(m, 4, 3);
    const Errors fine = sphere_errors(m, 8, 6);
    const double nu = m.poisson_ratio;
    std::printf("sphere, nu %.2f: radius %.2f %%, %.2f %%; force %.2f %%, %.2f %%\n", nu,
                100.0 * coarse.displacement, 100.0 * fine.displacement, 100.0 * coarse.force,
                100.0 * fine.force);
    EXPECT_LT(std::abs(fine.displacement), 0.02);
    EXPECT_LT(std::abs(fine.force), nu < 0.48 ? 0.05 : 0.2);
    EXPECT_GT(std::abs(coarse.force / fine.force), 2.5);
  }
}

/// Smoothed tets do not lock: errors at nu = 0.499 are those at 0.45, and of second order. Those of the force
/// with linear tets of the mesh with 4 x 3 cells are 13 % at 0.45 and 50 % at 0.49.
/// \param most   of the fine mesh: errors of displacement and force
/// \param least  ratio of the errors of both meshes
void expect_second_order(const std::array<int, 2>& coarse_cells, const std::array<int, 2>& fine_cells,
                         const Errors& most, double least) {
  for (const double nu : {0.45, 0.499}) {
    Material m = tissue(MaterialModel::stable_neo_hookean, nu);
    m.elements = ElementKind::smoothed;
    const Errors coarse = sphere_errors(m, coarse_cells[0], coarse_cells[1]);
    const Errors fine = sphere_errors(m, fine_cells[0], fine_cells[1]);
    std::printf("sphere of smoothed tets, nu %.3f: radius %.2f %%, %.2f %%; force %.2f %%, %.2f %%\n", nu,
                100.0 * coarse.displacement, 100.0 * fine.displacement, 100.0 * coarse.force,
                100.0 * fine.force);
    EXPECT_LT(std::abs(fine.displacement), most.displacement);
    EXPECT_LT(std::abs(fine.force), most.force);
    EXPECT_GT(std::abs(coarse.displacement / fine.displacement), least);
    EXPECT_GT(std::abs(coarse.force / fine.force), least);
  }
}

TEST(LargeStrain, AThickSphereOfSmoothedTetsBlownUpBy30Percent) {
  expect_second_order({3, 2}, {6, 4}, {0.04, 0.05}, 2.5);
}

TEST(LargeStrain, DISABLED_AThickSphereOfManySmoothedTetsBlownUpBy30Percent) {
  expect_second_order({4, 3}, {8, 6}, {0.02, 0.03}, 3.0);
}

/// A cylinder of radius 1 and any length, twisted by `twist` a length, whose length is kept.
RadialSolution twisted(const Material& m, double twist, int elements) {
  const auto energy_of = [&](Real radius, Real r, Real slope) {
    Matrix f = diagonal(slope, r / radius, 1);
    f(1, 2) = Real(twist) * r;
    return 2 * Real(pi) * radius * energy(m, f, 0);
  };
  return RadialProblem(energy_of, 1e-9, 1.0, elements).solve([](double radius) { return radius; }, false);
}

/// Torque: the derivative of the least energy by the twist.
double torque(const Material& m, double twist) {
  constexpr double d = 1e-3;
  return (twisted(m, twist + d, 150).energy - twisted(m, twist - d, 150).energy) / (2.0 * d);
}

/// Simple torsion of an incompressible law W(I1, I2) (Rivlin 1948): 4 pi times the integral of twist R^3
/// (dW/dI1 + dW/dI2), here with the stable neo-Hookean W = mu/2 (I1 - ln(I1 + 1)) + c01 I2.
double incompressible_torque(const Material& m, double twist) {
  const double c = m.model == MaterialModel::mooney_rivlin ? m.mooney_fraction : 0.0;
  const double shear = m.young_modulus / 3.0;
  const double mu = 4.0 / 3.0 * (1.0 - c) * shear;
  const double second = 0.5 * c * shear;
  double sum = 0.0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double radius = (i + 0.5) / n;
    const double first = 0.5 * mu * (1.0 - 1.0 / (4.0 + twist * twist * radius * radius));
    sum += 4.0 * pi * twist * radius * radius * radius * (first + second) / n;
  }
  return sum;
}

TEST(LargeStrain, TheReferenceOfTorsionHasTheClosedFormAsItsLimit) {
  for (const MaterialModel model : {MaterialModel::stable_neo_hookean, MaterialModel::mooney_rivlin}) {
    const Material m = tissue(model, 0.49999);
    EXPECT_NEAR(torque(m, 0.8) / incompressible_torque(m, 0.8), 1.0, 1e-3);
  }
}

/// Fibres on helices about the z axis, at this angle to it, as `direction` in radial axes.
constexpr double helix_angle = pi / 6.0;
Fibres helices(double angle, double exponent) {
  return {.direction = {0.0, std::sin(angle), std::cos(angle)}, .stiffness = 1e4, .exponent = exponent};
}

/// The same fibres, for each tet at its centre; none if the material has none.
Materials with_helices(const Bodies& bodies, const Material& m) {
  Materials materials{m};
  if (!m.fibres.any()) return materials;
  const auto rest = bodies.points_rest();
  for (const Tet& t : bodies.tets()) {
    Vec3 centre{};
    for (const Index corner : t) centre += 0.25 * at(rest, corner);
    const Vec3 around = normalized(Vec3{-centre.y, centre.x, 0.0});
    materials.fibre_of_tet.push_back(m.fibres.direction.y * around + Vec3{0.0, 0.0, m.fibres.direction.z});
  }
  return materials;
}

double torque_error(const Material& m, int across) {
  constexpr double twist = 0.6;
  constexpr double height = 1.0;
  const Bodies bodies = single_body(cylinder_mesh(across, across / 2, 1.0, height));
  const RadialSolution expected = twisted(m, twist, 200);
  const auto rest = bodies.points_rest();
  const auto held = select(bodies, [](const Vec3& p) { return p.z == 0.0 || p.z == height; });
  const Equilibrium found = equilibrium(bodies, with_helices(bodies, m), held, [&](const Vec3& p) {
    const double radius = std::hypot(p.x, p.y);
    const double scale = radius > 0.0 ? expected.at(radius) / radius : 1.0;
    return palpate::test::rotated({scale * p.x, scale * p.y, p.z}, {0.0, 0.0, 1.0}, twist * p.z);
  });
  double sum = 0.0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (rest[i].z == height) sum -= cross(found.positions[i], found.forces[i]).z;
  }
  return sum / torque(m, twist) - 1.0;
}

/// Torque by fibres on helices at constant volume, with E = 2 t R s c + t^2 R^2 c^2 for the twist t: 2 pi
/// times the integral of R k1 E exp(k2 E^2) dE/dt. For fibres along the axis and k2 = 0 it is 2/3 pi k1 t^3.
double fibre_torque(const Material& m, double twist) {
  const double s = m.fibres.direction.y;
  const double c = m.fibres.direction.z;
  double sum = 0.0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double radius = (i + 0.5) / n;
    const double strain = 2.0 * twist * radius * s * c + std::pow(twist * radius * c, 2);
    const double slope = 2.0 * radius * s * c + 2.0 * twist * std::pow(radius * c, 2);
    sum += 2.0 * pi * radius * m.fibres.stiffness * strain * std::exp(m.fibres.exponent * strain * strain) *
           slope / n;
  }
  return sum;
}

TEST(LargeStrain, TheReferenceOfTorsionWithFibresHasTheClosedFormAsItsLimit) {
  constexpr double twist = 0.8;
  for (const auto& [angle, exponent] : {std::pair{0.0, 0.0}, {0.0, 1.0}, {helix_angle, 1.0}}) {
    Material m = tissue(MaterialModel::stable_neo_hookean, 0.49999);
    m.fibres = helices(angle, exponent);
    const double fibres = fibre_torque(m, twist);
    if (angle == 0.0 && exponent == 0.0) {
      EXPECT_NEAR(fibres / (2.0 / 3.0 * pi * m.fibres.stiffness * std::pow(twist, 3)), 1.0, 1e-6);
    }
    EXPECT_GT(fibres / incompressible_torque(m, twist), 0.2);
    EXPECT_NEAR(torque(m, twist) / (incompressible_torque(m, twist) + fibres), 1.0, 1e-3);
  }
}

/// Errors are of second order: the extrapolated value is the torque.
TEST(LargeStrain, ACylinderTwistedBy34Degrees) {
  for (const Material& m :
       {tissue(MaterialModel::stable_neo_hookean, 0.3), tissue(MaterialModel::stable_neo_hookean, 0.45),
        tissue(MaterialModel::mooney_rivlin, 0.3)}) {
    const double coarse = torque_error(m, 8);
    const double fine = torque_error(m, 12);
    const double extrapolated = (2.25 * fine - coarse) / 1.25;
    std::printf("torsion, nu %.2f: torque %.2f %%, %.2f %%; extrapolated %.2f %%\n", m.poisson_ratio,
                100.0 * coarse, 100.0 * fine, 100.0 * extrapolated);
    EXPECT_LT(std::abs(extrapolated), 0.01);
    EXPECT_GT(std::abs(coarse / fine), 1.8);
  }
}

/// With fibres along the axis and on helices, which the twist stretches at constant length.
TEST(LargeStrain, ACylinderWithFibresTwistedBy34Degrees) {
  for (const double angle : {0.0, helix_angle}) {
    Material m = tissue(MaterialModel::stable_neo_hookean, 0.3);
    m.fibres = helices(angle, 1.0);
    const double coarse = torque_error(m, 8);
    const double fine = torque_error(m, 12);
    const double extrapolated = (2.25 * fine - coarse) / 1.25;
    std::printf("torsion with fibres at %.0f degrees: torque %.2f %%, %.2f %%; extrapolated %.2f %%\n",
                180.0 / pi * angle, 100.0 * coarse, 100.0 * fine, 100.0 * extrapolated);
    EXPECT_LT(std::abs(extrapolated), 0.01);
    EXPECT_GT(std::abs(coarse / fine), 1.8);
  }
}

}  // namespace
}  // namespace palpate::fem::test

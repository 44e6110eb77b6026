// Hyperelastic laws. Oracles: the energies as their papers write them, in long double, differentiated by
// differences; their Hessians with negative eigenvalues replaced by Eigen; closed forms of simple stretches.
#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "fem/hyperelastic.hpp"
#include "fem/laws.hpp"
#include "fem/meshes.hpp"
#include "fem/pulled_tangent.hpp"
#include "fem/stress.hpp"

namespace palpate::fem::test {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// d vec(P) / d vec(F), row by row.
Matrix9 hessian(const Material& m, const Matrix& f, Real tension, Real ambient = 0) {
  constexpr Real d = 1e-4L;
  Matrix9 c;
  for (int k = 0; k < 9; ++k) {
    Matrix plus = f;
    Matrix minus = f;
    plus(k / 3, k % 3) += d;
    minus(k / 3, k % 3) -= d;
    const Matrix change = (stress(m, plus, tension, ambient) - stress(m, minus, tension, ambient)) / (2 * d);
    for (int i = 0; i < 9; ++i) c(i, k) = static_cast<double>(change(i / 3, i % 3));
  }
  return 0.5 * (c + c.transpose());
}

/// A matrix with each negative eigenvalue replaced by minus the part `kept` of it.
Matrix9 positive_part(const Matrix9& a, double kept) {
  const Eigen::SelfAdjointEigenSolver<Matrix9> solver(a);
  const auto& values = solver.eigenvalues();
  return solver.eigenvectors() * values.cwiseMax(-kept * values).asDiagonal() *
         solver.eigenvectors().transpose();
}

Material with(MaterialModel model, double nu, double fraction = 0.5) {
  return {.young_modulus = 2e4, .poisson_ratio = nu, .model = model, .mooney_fraction = fraction};
}

std::vector<Material> isotropic() {
  std::vector<Material> all;
  for (const double nu : {0.0, 0.3, 0.45, 0.499}) {
    all.push_back(with(MaterialModel::stable_neo_hookean, nu));
    if (nu > 0.0) all.push_back(with(MaterialModel::mooney_rivlin, nu, 1.0));
    all.push_back(with(MaterialModel::mooney_rivlin, nu, 0.3));
  }
  return all;
}

/// Whether the energy of fibres has a second derivative: not where stretch begins, nor where the polynomial
/// does.
bool is_smooth(const Material& m, const Matrix& f) {
  if (!m.fibres.any()) return true;
  const Vec3& a = m.fibres.direction;
  const auto w = (f.cast<double>() * to_eigen(a)).norm() / length(a);
  const double e = w * w - 1.0;
  return std::abs(e) > 0.01 && m.fibres.exponent * e * e < 15.9;
}

HyperelasticLaw law_of(const Material& m, double tension = 0.0, double ambient = 0.0) {
  const auto [first, second] = invariant_moduli(m);
  HyperelasticLaw law{.first = first,
                      .second = second,
                      .bulk = bulk_of(static_cast<double>(Lame(m).lambda), first),
                      .ambient = ambient};
  if (!m.fibres.any()) return law;
  law.fibre = (1.0 / length(m.fibres.direction)) * m.fibres.direction;
  law.fibre_stiffness = m.fibres.stiffness;
  law.fibre_exponent = m.fibres.exponent;
  law.tension = tension;
  return law;
}

Matrix3 minus_identity(const Matrix& f) {
  return from_eigen((f - Matrix::Identity()).cast<double>());
}

/// Deformations with given singular values and random rotations.
std::vector<Matrix> deformations(unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<Matrix> all;
  const std::vector<Eigen::Vector3d> stretches{
      {1.0, 1.0, 1.0},  {1.3, 1.1, 0.9},   {2.0, 0.7, 0.6}, {0.5, 0.5, 0.5}, {3.0, 3.0, 0.1},
      {1.0, 0.9, -0.5}, {1.2, 1.2, -0.05}, {0.9, 0.4, 0.1}, {1.1, 1.1, 1.1}, {1.001, 1.0, 0.999}};
  for (const Eigen::Vector3d& s : stretches) {
    const Eigen::Matrix3d u = to_eigen(random_rotation(random));
    const Eigen::Matrix3d v = to_eigen(random_rotation(random));
    all.emplace_back((u * s.asDiagonal() * v.transpose()).cast<Real>());
  }
  return all;
}

void expect_stress(const Material& m, double tension, double ambient = 0.0) {
  for (const Matrix& f : deformations(5)) {
    if (!is_smooth(m, f)) continue;
    const HyperelasticResponse r = respond(law_of(m, tension, ambient), minus_identity(f));
    const Matrix exact = stress(m, f, tension, ambient);
    const double size = static_cast<double>(exact.norm() + Lame(m).mu);
    EXPECT_LT((to_eigen(r.stress) - exact.cast<double>()).norm(), 1e-9 * size);
    const Real here = energy(m, f, tension, ambient) - energy(m, Matrix::Identity(), tension, ambient);
    EXPECT_NEAR(r.energy_density, static_cast<double>(here),
                1e-12 * static_cast<double>(std::abs(here) + Lame(m).mu));
  }
}

constexpr std::array<Vec3, 3> gradients{Vec3{1.0, 0.2, -0.3}, Vec3{0.1, 1.5, 0.4}, Vec3{-0.7, 0.3, 0.9}};

/// The blocks above the diagonal are those of a tangent d vec(P) / d vec(F), times `scale`.
void expect_blocks(const std::array<double, tangent_values>& blocks, const Matrix9& c, double scale) {
  const std::array<Vec3, 4> g{-(gradients[0] + gradients[1] + gradients[2]), gradients[0], gradients[1],
                              gradients[2]};
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      for (int a = 0; a < 3; ++a) {
        for (int b = 0; b < 3; ++b) {
          double sum = 0.0;
          for (int k = 0; k < 3; ++k) {
            for (int l = 0; l < 3; ++l)
              sum += to_eigen(at(g, i))[k] * c(3 * a + k, 3 * b + l) * to_eigen(at(g, j))[l];
          }
          EXPECT_NEAR(at(blocks, static_cast<Index>(block_place(i, j)) + 3 * a + b), scale * sum,
                      1e-6 * scale * c.norm());
        }
      }
    }
  }
}

/// Whether the law without fibres has a tension of volume, and F is not inverted.
bool is_swollen(const Material& m, const Matrix& f, double ambient) {
  const HyperelasticLaw law = law_of(m, 0.0, ambient);
  const Real j = f.determinant();
  return j > 0 && Real(law.bulk) * (j - 1) > Real(law.rest_pressure());
}

/// The blocks are those of the exact Hessian without its negative eigenvalues, of which a part is kept.
void expect_tangent(const Material& m, double tension, double ambient = 0.0) {
  for (const Matrix& f : deformations(6)) {
    if (!is_smooth(m, f)) continue;
    Material ground = m;
    ground.fibres = {};
    constexpr double kept = 0.3;
    Matrix9 c = positive_part(hessian(ground, f, 0, ambient), is_swollen(ground, f, ambient) ? kept : 0.0);
    if (m.fibres.any()) c += hessian(m, f, tension) - hessian(ground, f, 0);
    const HyperelasticLaw law = law_of(m, tension, ambient);
    std::array<double, tangent_values> blocks{};
    put_blocks(tangent(law, minus_identity(f), kept), law.fibre, gradients, 2.0, blocks);
    expect_blocks(blocks, c, 2.0);
  }
}

TEST(MaterialStress, IsTheDerivativeOfTheEnergyOfThePaper) {
  for (const Material& m : isotropic()) expect_stress(m, 0.0);
}

TEST(MaterialTangent, IsTheHessianWithoutItsNegativeEigenvalues) {
  for (const Material& m : isotropic()) expect_tangent(m, 0.0);
}

TEST(MaterialStress, HasTheWorkAgainstAnAmbientPressure) {
  for (const Material& m : isotropic()) {
    for (const double ambient : {4e3, -7e3, 1e5}) {
      expect_stress(m, 0.0, ambient);
      expect_tangent(m, 0.0, ambient);
    }
  }
}

TEST(FibreMaterial, HasStressAndTangentOfItsEnergy) {
  Material m = with(MaterialModel::stable_neo_hookean, 0.45);
  for (const double exponent : {0.0, 0.2}) {
    m.fibres = Fibres{.direction = {1.0, -2.0, 0.5}, .stiffness = 3e3, .exponent = exponent};
    expect_stress(m, 0.0);
    expect_stress(m, 5e3);
    expect_tangent(m, 5e3);
  }
}

/// Where fibres pull, the tangent is the exact Hessian of fibres and tissue together, without the negative
/// part of S = F^-1 P in the term dF S of dP; and it has no negative eigenvalue.
TEST(FibreMaterial, ThatPullsHasTheWholeTangent) {
  std::mt19937_64 random(8);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  int whole = 0;
  for (const Material& base :
       {with(MaterialModel::stable_neo_hookean, 0.45), with(MaterialModel::mooney_rivlin, 0.3),
        with(MaterialModel::stable_neo_hookean, 0.0)}) {
    Material m = base;
    m.fibres = Fibres{.direction = {1.0, -2.0, 0.5}, .stiffness = 3e3, .exponent = 0.2};
    for (int n = 0; n < 30; ++n) {
      const Eigen::Vector3d s(0.8 + 0.4 * uniform(random), 0.8 + 0.4 * uniform(random),
                              0.8 + 0.4 * uniform(random));
      const Matrix f =
          (to_eigen(random_rotation(random)) * s.asDiagonal() * to_eigen(random_rotation(random)).transpose())
              .cast<Real>();
      if (!is_smooth(m, f)) continue;
      const double tension = 2e4 * uniform(random);
      const double ambient = n % 2 == 0 ? 0.0 : 1e4 * uniform(random);
      std::array<double, tangent_values> blocks{};
      if (!put_pulled_blocks(law_of(m, tension, ambient), minus_identity(f), gradients, 2.0, blocks))
        continue;
      ++whole;
      const Eigen::Matrix3d stress_now = stress(m, f, tension, ambient).cast<double>();
      const Eigen::Matrix3d second = f.cast<double>().inverse() * stress_now;
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(0.5 * (second + second.transpose()));
      const Eigen::Matrix3d negative = solver.eigenvectors() *
                                       solver.eigenvalues().cwiseMin(0.0).asDiagonal() *
                                       solver.eigenvectors().transpose();
      Matrix9 c = hessian(m, f, tension, ambient);
      for (int i = 0; i < 3; ++i) c.block<3, 3>(3 * i, 3 * i) -= negative;
      expect_blocks(blocks, c, 2.0);
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix9>(c).eigenvalues()[0], -1e-5 * c.norm());
    }
  }
  EXPECT_GT(whole, 60);
}

/// Beyond the range of the exponential: finite, and smooth at the border to the polynomial.
TEST(FibreMaterial, IsSmoothAndFiniteAtAnyStretch) {
  Material m = with(MaterialModel::stable_neo_hookean, 0.4);
  m.fibres = Fibres{.direction = {1.0, 0.0, 0.0}, .stiffness = 1e4, .exponent = 4.0};
  const auto at_stretch = [&](double s) {
    return respond(law_of(m), Matrix3{{s - 1.0, 0, 0, 0, 0, 0, 0, 0, 0}});
  };
  const double border = std::sqrt(3.0);  // E = 2: exponent E^2 = 16
  const HyperelasticResponse below = at_stretch(border - 1e-7);
  const HyperelasticResponse above = at_stretch(border + 1e-7);
  EXPECT_NEAR(above.energy_density / below.energy_density, 1.0, 2e-5);
  EXPECT_NEAR(above.stress(0, 0) / below.stress(0, 0), 1.0, 2e-5);
  EXPECT_TRUE(std::isfinite(at_stretch(1e6).stress(0, 0)));
  EXPECT_GT(at_stretch(1e6).stress(0, 0), at_stretch(1e5).stress(0, 0));
}

/// Closed form of the nominal stress along axis i of diag(s): Smith et al., or with C01.
double nominal(const Material& m, const std::array<double, 3>& s, std::size_t i) {
  const Lame lame(m);
  const double c = m.model == MaterialModel::mooney_rivlin ? m.mooney_fraction : 0.0;
  const double second = c * static_cast<double>(lame.mu);
  const double mu = 4.0 / 3.0 * (1.0 - c) * static_cast<double>(lame.mu);
  const double lambda = static_cast<double>(lame.lambda) + 5.0 / 8.0 * mu;
  const double alpha = 1.0 + (0.75 * mu + 2.0 * second) / lambda;
  const double j = s[0] * s[1] * s[2];
  const double first = s[0] * s[0] + s[1] * s[1] + s[2] * s[2];
  return mu * s[i] * (1.0 - 1.0 / (first + 1.0)) + second * s[i] * (first - s[i] * s[i]) +
         lambda * (j - alpha) * j / s[i];
}

TEST(MaterialClosedForm, UniaxialEquibiaxialShearAndVolumetric) {
  for (const Material& m : isotropic()) {
    const auto cauchy = [&](const Matrix3& f) {
      const ElementDeformation e{.gradient = f,
                                 .rotation = identity(),
                                 .stretch = {},
                                 .plastic_strain = {},
                                 .twist = {},
                                 .mu = 0.0,
                                 .lambda = 0.0,
                                 .hyperelastic = true,
                                 .law = law_of(m)};
      return stress_of(e);
    };
    const double unit = static_cast<double>(Lame(m).mu + Lame(m).lambda);
    for (const double s : {0.5, 0.8, 1.0, 1.3, 2.0}) {
      const double side = zero_of([&](double t) { return nominal(m, {s, t, t}, 1); }, 0.1, 4.0);
      const ElementStress uniaxial = cauchy({{s, 0, 0, 0, side, 0, 0, 0, side}});
      EXPECT_NEAR(uniaxial.stress.xx, nominal(m, {s, side, side}, 0) / (side * side), 1e-9 * unit);
      EXPECT_NEAR(uniaxial.stress.yy, 0.0, 1e-9 * unit);
      EXPECT_NEAR(von_mises(uniaxial.stress), std::abs(uniaxial.stress.xx), 1e-9 * unit);
      const double thick = zero_of([&](double t) { return nominal(m, {s, s, t}, 2); }, 0.01, 8.0);
      const ElementStress biaxial = cauchy({{s, 0, 0, 0, s, 0, 0, 0, thick}});
      EXPECT_NEAR(biaxial.stress.xx, nominal(m, {s, s, thick}, 0) / (s * thick), 1e-9 * unit);
      EXPECT_NEAR(biaxial.stress.zz, 0.0, 1e-9 * unit);
      const ElementStress volumetric = cauchy({{s, 0, 0, 0, s, 0, 0, 0, s}});
      EXPECT_NEAR(volumetric.stress.xx, nominal(m, {s, s, s}, 0) / (s * s), 1e-9 * unit);
      EXPECT_NEAR(volumetric.volume_ratio, s * s * s, 1e-12);
      // Simple shear k: sigma_xy = (linear - ...) of B = F F^T with J = 1 (Rivlin's universal relation
      // sigma_xx - sigma_yy = k sigma_xy holds for every isotropic law).
      const double k = s;
      const ElementStress shear = cauchy({{1, k, 0, 0, 1, 0, 0, 0, 1}});
      EXPECT_NEAR(shear.stress.xx - shear.stress.yy, k * shear.stress.xy, 1e-9 * unit);
      const double c = m.model == MaterialModel::mooney_rivlin ? m.mooney_fraction : 0.0;
      const double mu = static_cast<double>(Lame(m).mu);
      const double by_hand = k * (4.0 / 3.0 * (1.0 - c) * mu * (1.0 - 1.0 / (k * k + 4.0)) + c * mu);
      EXPECT_NEAR(shear.stress.xy, by_hand, 1e-9 * unit);
    }
  }
}

TEST(MaterialClosedForm, SmallStrainsAreHookesLaw) {
  for (const Material& m : isotropic()) {
    const double e = 1e-7;
    const HyperelasticResponse r =
        respond(law_of(m), Matrix3{{e, 0.4 * e, 0, 0.4 * e, -0.3 * e, 0, 0, 0, 0.2 * e}});
    const auto mu = static_cast<double>(Lame(m).mu);
    const auto lambda = static_cast<double>(Lame(m).lambda);
    const double trace = 0.9 * e;
    EXPECT_NEAR(r.stress(0, 0), 2.0 * mu * e + lambda * trace, 1e-5 * e * (mu + lambda));
    EXPECT_NEAR(r.stress(1, 1), -0.6 * mu * e + lambda * trace, 1e-5 * e * (mu + lambda));
    EXPECT_NEAR(r.stress(0, 1), 0.8 * mu * e, 1e-5 * e * (mu + lambda));
    EXPECT_NEAR(r.energy_density, mu * e * e * (1.0 + 0.09 + 0.04 + 0.32) + 0.5 * lambda * trace * trace,
                1e-5 * e * e * (mu + lambda));
  }
}

}  // namespace
}  // namespace palpate::fem::test

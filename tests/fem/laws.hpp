#pragma once

#include <Eigen/Dense>
#include <Eigen/SVD>
#include <cmath>

#include <palpate/material.hpp>

/// Hyperelastic laws as their papers write them, in long double: an oracle that shares nothing with ours.
namespace palpate::fem::test {

using Real = long double;
using Matrix = Eigen::Matrix<Real, 3, 3>;

struct Lame {
  explicit Lame(const Material& m)
      : mu(Real(m.young_modulus) / (2 * (1 + Real(m.poisson_ratio)))),
        lambda(Real(m.young_modulus) * m.poisson_ratio /
               ((1 + Real(m.poisson_ratio)) * (1 - 2 * Real(m.poisson_ratio)))) {}
  Real mu;
  Real lambda;
};

/// Smith, de Goes & Kim 2018, eq. 14 with the reparametrisation of their section 3.4; for Mooney-Rivlin
/// with C01 (I2 - 3) added and alpha and moduli such that rest is Hooke's law. Fibres of Holzapfel, Gasser &
/// Ogden 2000. The work against an ambient pressure is added.
inline Real energy(const Material& m, const Matrix& f, Real tension, Real ambient = 0) {
  const Lame lame(m);
  const Real c = m.model == MaterialModel::mooney_rivlin ? Real(m.mooney_fraction) : Real(0);
  const Real c01 = c * lame.mu / 2;
  const Real mu = Real(4) / 3 * (lame.mu - 2 * c01);
  const Real lambda = lame.lambda + Real(5) / 8 * mu;
  const Real alpha = 1 + (Real(3) / 4 * mu + 4 * c01) / lambda;
  const Real first = f.squaredNorm();
  const Real j = f.determinant();
  const Real second = (first * first - (f.transpose() * f).squaredNorm()) / 2;
  Real sum = mu / 2 * (first - 3) + lambda / 2 * (j - alpha) * (j - alpha) - mu / 2 * std::log(first + 1) +
             c01 * (second - 3) + ambient * (j - 1);
  if (!m.fibres.any()) return sum;
  const Eigen::Matrix<Real, 3, 1> a =
      Eigen::Matrix<Real, 3, 1>(m.fibres.direction.x, m.fibres.direction.y, m.fibres.direction.z)
          .normalized();
  const Real i4 = (f * a).squaredNorm();
  const Real k1 = m.fibres.stiffness;
  const Real k2 = m.fibres.exponent;
  if (i4 > 1)
    sum += k2 > 0 ? k1 / (2 * k2) * std::expm1(k2 * (i4 - 1) * (i4 - 1)) : k1 / 2 * (i4 - 1) * (i4 - 1);
  return sum + tension * std::sqrt(i4 + Real(1e-6));
}

inline Matrix stress(const Material& m, const Matrix& f, Real tension, Real ambient = 0) {
  constexpr Real d = 1e-5L;
  Matrix p;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const auto shifted = [&](Real by) {
        Matrix g = f;
        g(i, j) += by;
        return energy(m, g, tension, ambient);
      };
      p(i, j) = (8 * (shifted(d) - shifted(-d)) - (shifted(2 * d) - shifted(-2 * d))) / (12 * d);
    }
  }
  return p;
}

/// First Piola-Kirchhoff stress of any law; the corotational one after Mueller & Gross 2004, with the
/// rotation of the polar decomposition by Eigen.
inline Matrix stress(const Material& m, const Matrix& f) {
  if (m.model != MaterialModel::corotational) return stress(m, f, 0);
  const Lame lame(m);
  const Eigen::JacobiSVD<Matrix> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix r = svd.matrixU() * svd.matrixV().transpose();
  return 2 * lame.mu * (f - r) + lame.lambda * (svd.singularValues().sum() - 3) * r;
}

}  // namespace palpate::fem::test

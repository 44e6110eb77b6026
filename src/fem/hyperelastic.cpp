#include "fem/hyperelastic.hpp"

#include <algorithm>
#include <cmath>

#include "fem/plasticity.hpp"
#include "fem/rotation.hpp"
#include "fem/symmetric_eigen.hpp"
#include "geometry/exponential.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

/// Above this value of exponent E^2, the energy of fibres is continued as a polynomial.
constexpr double most_argument = 16.0;
/// Added to I4 before the square root of the length of an active fibre.
constexpr double least_squared_length = 1e-6;

/// Energy of fibres: value and derivatives by I4.
struct FibreEnergy {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;
};

/// (e^x - 1) / x for x >= 0.
double mean_growth(double x) {
  return x < 1e-4 ? 1.0 + x * (0.5 + x / 6.0) : (exponential(x) - 1.0) / x;
}

FibreEnergy passive_energy(double stiffness, double exponent, double e) {
  if (!(e > 0.0) || stiffness == 0.0) return {};
  const bool beyond = exponent * e * e > most_argument;
  const double at = beyond ? std::sqrt(most_argument / exponent) : e;
  const double x = exponent * at * at;
  const double growth = exponential(x);
  FibreEnergy energy{0.5 * stiffness * at * at * mean_growth(x), stiffness * at * growth,
                     stiffness * growth * (1.0 + 2.0 * x)};
  if (beyond) {
    const double more = e - at;
    energy.value += more * (energy.slope + 0.5 * energy.curvature * more);
    energy.slope += energy.curvature * more;
  }
  return energy;
}

Matrix3 product(const SymmetricMatrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int j = 0; j < 3; ++j) {
    const Vec3 column = a * Vec3{b(0, j), b(1, j), b(2, j)};
    c(0, j) = column.x;
    c(1, j) = column.y;
    c(2, j) = column.z;
  }
  return c;
}

SymmetricMatrix3 positive_part(const SymmetricMatrix3& a, double kept) {
  const double minor = a.xx * a.yy - a.xy * a.xy;
  const double det = a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.yz * a.xz) +
                     a.xz * (a.xy * a.yz - a.yy * a.xz);
  if (a.xx > 0.0 && minor > 0.0 && det > 0.0) return a;
  return positive_part(symmetric_eigen(a), kept);
}

/// Second derivatives of the energy in principal stretches.
struct PrincipalTerms {
  double first = 0.0;     ///< first (1 - 1 / (I1 + 1))
  double bend = 0.0;      ///< 2 first / (I1 + 1)^2
  double pressure = 0.0;  ///< of J
  double kept = 0.0;      ///< part of negative eigenvalues
};

/// A diagonal entry of the tangent in principal stretches. c is the cofactor s_j s_k; `squares` is s_j^2 +
/// s_k^2.
double diagonal_entry(const HyperelasticLaw& law, const PrincipalTerms& t, double s, double c,
                      double squares) {
  return t.first + t.bend * s * s + law.second * squares + law.bulk * c * c;
}

void set_principal(const HyperelasticLaw& law, const Vec3& s, double volume_change, double kept,
                   HyperelasticTangent& t) {
  const Vec3 c{s.y * s.z, s.z * s.x, s.x * s.y};
  const Vec3 q{s.x * s.x, s.y * s.y, s.z * s.z};
  const double weight = 1.0 / (q.x + q.y + q.z + 1.0);
  const double pressure = law.bulk * volume_change - law.rest_pressure();
  const PrincipalTerms terms{law.first * (1.0 - weight), 2.0 * law.first * weight * weight, pressure,
                             pressure > 0.0 && volume_change > -1.0 ? kept : 0.0};
  const auto mixed = [&](double product, double c_i, double c_j, double s_k) {
    return (terms.bend + 2.0 * law.second) * product + law.bulk * c_i * c_j + terms.pressure * s_k;
  };
  t.stretch = positive_part(
      {diagonal_entry(law, terms, s.x, c.x, q.y + q.z), diagonal_entry(law, terms, s.y, c.y, q.z + q.x),
       diagonal_entry(law, terms, s.z, c.z, q.x + q.y), mixed(c.z, c.x, c.y, s.z), mixed(c.y, c.x, c.z, s.y),
       mixed(c.x, c.y, c.z, s.x)},
      terms.kept);
  const auto pair = [&](double c_k, double q_k, double s_k, double& same, double& other) {
    const double twist = std::max(0.0, terms.first + law.second * (q_k + c_k) + terms.pressure * s_k);
    const double flip = terms.first + law.second * (q_k - c_k) - terms.pressure * s_k;
    const double positive_flip = std::max(flip, -terms.kept * flip);
    same = 0.5 * (positive_flip + twist);
    other = 0.5 * (positive_flip - twist);
  };
  pair(c.x, q.x, s.x, t.same.x, t.other.x);
  pair(c.y, q.y, s.y, t.same.y, t.other.y);
  pair(c.z, q.z, s.z, t.same.z, t.other.z);
}

/// V^T g
Vec3 right_frame(const HyperelasticTangent& t, const Vec3& g) {
  return {t.right(0, 0) * g.x + t.right(1, 0) * g.y + t.right(2, 0) * g.z,
          t.right(0, 1) * g.x + t.right(1, 1) * g.y + t.right(2, 1) * g.z,
          t.right(0, 2) * g.x + t.right(1, 2) * g.y + t.right(2, 2) * g.z};
}

/// Stiffness block U M U^T between two corners; a and b are V^T g of the two.
Matrix3 rotated_block(const HyperelasticTangent& t, const Vec3& a, const Vec3& b) {
  const Vec3 p{a.x * b.x, a.y * b.y, a.z * b.z};
  const Matrix3 m = from_rows(
      {t.stretch.xx * p.x + t.same.z * p.y + t.same.y * p.z, t.stretch.xy * a.x * b.y + t.other.z * a.y * b.x,
       t.stretch.xz * a.x * b.z + t.other.y * a.z * b.x},
      {t.stretch.xy * a.y * b.x + t.other.z * a.x * b.y, t.same.z * p.x + t.stretch.yy * p.y + t.same.x * p.z,
       t.stretch.yz * a.y * b.z + t.other.x * a.z * b.y},
      {t.stretch.xz * a.z * b.x + t.other.y * a.x * b.z, t.stretch.yz * a.z * b.y + t.other.x * a.y * b.z,
       t.same.y * p.x + t.same.x * p.y + t.stretch.zz * p.z});
  Matrix3 left;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) left(i, j) += t.left(i, k) * m(k, j);
    }
  }
  Matrix3 block;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) block(i, j) = dot(row(left, i), row(t.left, j));
  }
  return block;
}

void add_fibre_block(const HyperelasticTangent& t, double weight, Matrix3& block) {
  add_outer(block, weight * t.fibre_along, t.stretched_fibre, t.stretched_fibre);
  for (int k = 0; k < 3; ++k) block(k, k) += weight * t.fibre_across;
}

}  // namespace

FibreState fibre_state(const HyperelasticLaw& law, const Matrix3& h) {
  if (law.fibre == Vec3{}) return {};
  const Vec3 change = h * law.fibre;
  const Vec3 w = law.fibre + change;
  const double e = 2.0 * dot(law.fibre, change) + squared_length(change);
  const FibreEnergy passive = passive_energy(law.fibre_stiffness, law.fibre_exponent, e);
  const double rest_length = std::sqrt(1.0 + least_squared_length);
  const double length = std::sqrt(1.0 + least_squared_length + e);
  const double pull = law.tension / length;
  // length - rest_length without cancellation
  return {w, passive.value + law.tension * (e / (length + rest_length)), 2.0 * passive.slope + pull,
          4.0 * passive.curvature - pull / (length * length)};
}

double volume_change(const Matrix3& h, const Matrix3& cofactors_of_h) {
  return trace(h) + trace(cofactors_of_h) + determinant(h);
}

InvariantModuli invariant_moduli(const Material& material) {
  const double mu = material.young_modulus / (2.0 * (1.0 + material.poisson_ratio));
  const double fraction = material.model == MaterialModel::mooney_rivlin ? material.mooney_fraction : 0.0;
  return {4.0 / 3.0 * (1.0 - fraction) * mu, fraction * mu};
}

HyperelasticResponse respond(const HyperelasticLaw& law, const Matrix3& h) {
  const Matrix3 ch = cofactors(h);
  const double j = volume_change(h, ch);
  const Matrix3 f = plus_identity(h);
  const double x = 2.0 * trace(h) + inner(h, h);  // I1 - 3
  Matrix3 k;                                      // cof F - I = tr(H) I - H^T + cof H
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) k(r, c) = ch(r, c) - h(c, r) + (r == c ? trace(h) : 0.0);
  }
  const double y = 2.0 * trace(k) + inner(k, k);  // I2 - 3
  const double rest = law.rest_pressure();
  const FibreState fibre = fibre_state(law, h);
  HyperelasticResponse result;
  result.energy_density = 0.5 * law.first * (x - log_of_one_plus(0.25 * x)) + 0.5 * law.second * y +
                          j * (0.5 * law.bulk * j - rest) + fibre.energy;
  const double i1 = x + 3.0;
  const double linear = law.first * (1.0 - 1.0 / (i1 + 1.0)) + law.second * i1;
  const double pressure = law.bulk * j - rest;
  const Matrix3 cubic = product(outer_square(f), f);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      const double cofactor = k(r, c) + (r == c ? 1.0 : 0.0);
      result.stress(r, c) = linear * f(r, c) - law.second * cubic(r, c) + pressure * cofactor;
    }
  }
  add_outer(result.stress, fibre.stress, fibre.stretched, law.fibre);
  return result;
}

HyperelasticTangent tangent(const HyperelasticLaw& law, const Matrix3& h, double kept) {
  const Matrix3 f = plus_identity(h);
  const Matrix3 rotation = nearest_rotation(f);
  const SymmetricEigen eigen =
      symmetric_eigen(SymmetricMatrix3{1.0, 1.0, 1.0, 0.0, 0.0, 0.0} + corotated_strain(f, rotation));
  HyperelasticTangent t;
  for (int k = 0; k < 3; ++k) {
    const Vec3& v = eigen.vectors[static_cast<std::size_t>(k)];
    const Vec3 u = rotation * v;
    t.right(0, k) = v.x;
    t.right(1, k) = v.y;
    t.right(2, k) = v.z;
    t.left(0, k) = u.x;
    t.left(1, k) = u.y;
    t.left(2, k) = u.z;
  }
  set_principal(law, eigen.values, volume_change(h, cofactors(h)), kept, t);
  const FibreState fibre = fibre_state(law, h);
  t.stretched_fibre = fibre.stretched;
  t.fibre_along = fibre.along;
  t.fibre_across = fibre.stress;
  return t;
}

Matrix3 stress_change_of(const HyperelasticTangent& t, const Vec3& fibre, const Matrix3& gradient_change) {
  const Matrix3 a = transposed_times(t.left, times_transposed(gradient_change, transposed(t.right)));
  const Matrix3 b =
      from_rows({t.stretch.xx * a(0, 0) + t.stretch.xy * a(1, 1) + t.stretch.xz * a(2, 2),
                 t.same.z * a(0, 1) + t.other.z * a(1, 0), t.same.y * a(0, 2) + t.other.y * a(2, 0)},
                {t.same.z * a(1, 0) + t.other.z * a(0, 1),
                 t.stretch.xy * a(0, 0) + t.stretch.yy * a(1, 1) + t.stretch.yz * a(2, 2),
                 t.same.x * a(1, 2) + t.other.x * a(2, 1)},
                {t.same.y * a(2, 0) + t.other.y * a(0, 2), t.same.x * a(2, 1) + t.other.x * a(1, 2),
                 t.stretch.xz * a(0, 0) + t.stretch.yz * a(1, 1) + t.stretch.zz * a(2, 2)});
  Matrix3 change = times_transposed(times_transposed(t.left, transposed(b)), t.right);
  const Vec3 stretched = gradient_change * fibre;
  add_outer(change, t.fibre_along * dot(t.stretched_fibre, stretched), t.stretched_fibre, fibre);
  add_outer(change, t.fibre_across, stretched, fibre);
  return change;
}

void put_blocks(const HyperelasticTangent& t, const Vec3& fibre, const std::array<Vec3, 3>& gradients,
                double scale, std::span<double, tangent_values> blocks) {
  std::array<Vec3, 3> turned;
  for (std::size_t i = 0; i < 3; ++i) turned[i] = right_frame(t, gradients[i]);
  put_blocks(
      [&](std::size_t a, std::size_t b) {
        Matrix3 block = rotated_block(t, turned[a], turned[b]);
        add_fibre_block(t, dot(fibre, gradients[a]) * dot(fibre, gradients[b]), block);
        return block;
      },
      scale, blocks);
}

}  // namespace palpate::fem

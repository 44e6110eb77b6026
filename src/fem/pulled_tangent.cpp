#include "fem/pulled_tangent.hpp"

#include <algorithm>
#include <cmath>

#include "fem/plasticity.hpp"
#include "fem/symmetric_eigen.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

/// Fibres that pull by less than this, relative to the modulus of the first invariant, are left out.
constexpr double least_pull = 1e-4;
/// A negative eigenvalue of this size, relative to the largest entry, may come from rounding.
constexpr double rounding = 1e-9;

Matrix3 cofactor_change(const Matrix3& f, const Matrix3& df) {
  const auto row_of = [&](int a, int b) {
    return cross(row(df, a), row(f, b)) + cross(row(f, a), row(df, b));
  };
  return from_rows(row_of(1, 2), row_of(2, 0), row_of(0, 1));
}

/// The change of the stress for a change of F, without fibres.
/// \param j  J - 1
Matrix3 stress_change(const HyperelasticLaw& law, const Matrix3& f, const Matrix3& cofactor, double j,
                      const Matrix3& df) {
  const double i1 = inner(f, f);
  const double weight = 1.0 / (i1 + 1.0);
  const double along = inner(f, df);
  const double linear = law.first * (1.0 - weight) + law.second * i1;
  const double bend = 2.0 * law.first * weight * weight + 2.0 * law.second;
  const double pressure = law.bulk * j - law.rest_pressure();
  const Matrix3 turned = cofactor_change(f, df);
  const double volume = law.bulk * inner(cofactor, df);
  Matrix3 change;
  for (std::size_t k = 0; k < 9; ++k) {
    change.values[k] = linear * df.values[k] + bend * along * f.values[k] + volume * cofactor.values[k] +
                       pressure * turned.values[k];
  }
  if (law.second == 0.0) return change;
  // of F F^T F
  const Matrix3 square = times_transposed(f, f);
  const auto product = [](const Matrix3& a, const Matrix3& b) { return times_transposed(a, transposed(b)); };
  const Matrix3 first = product(times_transposed(df, f), f);
  const Matrix3 second = product(times_transposed(f, df), f);
  const Matrix3 third = product(square, df);
  for (std::size_t k = 0; k < 9; ++k)
    change.values[k] -= law.second * (first.values[k] + second.values[k] + third.values[k]);
  return change;
}

/// The negative part of F^-1 P, negated.
SymmetricMatrix3 compression(const Matrix3& f, const Matrix3& stress) {
  const SymmetricMatrix3 s = symmetric_part(times_transposed(inverse(f), transposed(stress)));
  return positive_part(symmetric_eigen(-1.0 * s));
}

bool is_semi_definite(WholeTangent m) {
  double largest = 0.0;
  for (std::size_t k = 0; k < 9; ++k) largest = std::max(largest, std::abs(m[k][k]));
  for (std::size_t k = 0; k < 9; ++k) {
    const double pivot = m[k][k] + rounding * largest;
    if (!(pivot > 0.0)) return false;
    for (std::size_t i = k + 1; i < 9; ++i) {
      const double factor = m[i][k] / pivot;
      for (std::size_t j = k + 1; j < 9; ++j) m[i][j] -= factor * m[k][j];
    }
  }
  return true;
}

}  // namespace

bool pulled_tangent(const HyperelasticLaw& law, const Matrix3& h, WholeTangent& result) {
  const FibreState fibre = fibre_state(law, h);
  if (!(fibre.stress > least_pull * law.first)) return false;
  const Matrix3 f = plus_identity(h);
  const double change = volume_change(h, cofactors(h));
  constexpr double most_crushed = -0.5;  // S needs the inverse of F
  if (!(change > most_crushed)) return false;
  const Matrix3 cofactor = cofactors(f);
  const SymmetricMatrix3 held = compression(f, respond(law, h).stress);
  for (int j = 0; j < 3; ++j) {
    for (int d = 0; d < 3; ++d) {
      Matrix3 df;
      df(j, d) = 1.0;
      Matrix3 dp = stress_change(law, f, cofactor, change, df);
      const Vec3 dw = df * law.fibre;
      add_outer(dp, fibre.along * dot(fibre.stretched, dw), fibre.stretched, law.fibre);
      add_outer(dp, fibre.stress, dw, law.fibre);
      const Vec3 stiffened = held * row(df, j);
      dp(j, 0) += stiffened.x;
      dp(j, 1) += stiffened.y;
      dp(j, 2) += stiffened.z;
      for (std::size_t k = 0; k < 9; ++k) result[k][static_cast<std::size_t>(3 * j + d)] = dp.values[k];
    }
  }
  return is_semi_definite(result);
}

Matrix3 stress_change_of(const WholeTangent& tangent, const Matrix3& gradient_change) {
  Matrix3 change;
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t k = 0; k < 9; ++k) change.values[i] += tangent[i][k] * gradient_change.values[k];
  }
  return change;
}

Matrix3 block_of(const WholeTangent& tangent, const Vec3& a, const Vec3& b) {
  const std::array<double, 3> own{a.x, a.y, a.z};
  const std::array<double, 3> other{b.x, b.y, b.z};
  Matrix3 block;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0.0;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t d = 0; d < 3; ++d) sum += own[c] * other[d] * tangent[3 * i + c][3 * j + d];
      }
      block(static_cast<int>(i), static_cast<int>(j)) = sum;
    }
  }
  return block;
}

bool put_pulled_blocks(const HyperelasticLaw& law, const Matrix3& h, const std::array<Vec3, 3>& gradients,
                       double scale, std::span<double, tangent_values> blocks) {
  WholeTangent whole{};
  if (!pulled_tangent(law, h, whole)) return false;
  put_blocks([&](std::size_t a, std::size_t b) { return block_of(whole, gradients[a], gradients[b]); }, scale,
             blocks);
  return true;
}

}  // namespace palpate::fem

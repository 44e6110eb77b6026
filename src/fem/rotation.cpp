#include "fem/rotation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

namespace palpate::fem {
namespace {

/// Above this determinant, with the largest entry scaled to 1, Newton converges in a few steps.
constexpr double healthy_determinant = 0.01;
constexpr int newton_cap = 16;
/// Convergence is quadratic: a step this small leaves an error of its square.
constexpr double newton_small_step = 1e-8;
constexpr int jacobi_sweeps = 40;

using Matrix4 = std::array<std::array<double, 4>, 4>;

/// X <- (g X + X^-T / g) / 2 with g = sqrt(|X^-1| / |X|), from det X > 0.
std::optional<Matrix3> newton(Matrix3 x) {
  for (int i = 0; i < newton_cap; ++i) {
    const Matrix3 c = cofactors(x);
    const double d = dot(row(x, 0), row(c, 0));
    const double g = std::sqrt(std::sqrt(inner(c, c) / inner(x, x)) / d);
    const double a = 0.5 * g;
    const double b = 0.5 / (g * d);
    Matrix3 next;
    for (std::size_t k = 0; k < 9; ++k) next.values[k] = a * x.values[k] + b * c.values[k];
    const Matrix3 change = next - x;
    x = next;
    if (inner(change, change) < newton_small_step * newton_small_step) return x;
  }
  return std::nullopt;
}

/// q^T N q = tr(R(q)^T F) for unit quaternions q = (w, x, y, z).
Matrix4 quaternion_form(const Matrix3& f) {
  const double trace = f(0, 0) + f(1, 1) + f(2, 2);
  Matrix4 n{};
  n[0] = {trace, f(2, 1) - f(1, 2), f(0, 2) - f(2, 0), f(1, 0) - f(0, 1)};
  n[1] = {n[0][1], 2.0 * f(0, 0) - trace, f(0, 1) + f(1, 0), f(0, 2) + f(2, 0)};
  n[2] = {n[0][2], n[1][2], 2.0 * f(1, 1) - trace, f(1, 2) + f(2, 1)};
  n[3] = {n[0][3], n[1][3], n[2][3], 2.0 * f(2, 2) - trace};
  return n;
}

/// Rotates rows and columns p, q of n so that n[p][q] = 0, and the columns of `vectors` with them.
void jacobi_rotation(Matrix4& n, Matrix4& vectors, std::size_t p, std::size_t q) {
  const double theta = (n[q][q] - n[p][p]) / (2.0 * n[p][q]);
  // If theta overflows, t = 0: the entry is negligible.
  const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
  const double c = 1.0 / std::sqrt(t * t + 1.0);
  const double s = t * c;
  for (std::size_t k = 0; k < 4; ++k) {
    const double kp = n[k][p];
    const double kq = n[k][q];
    n[k][p] = c * kp - s * kq;
    n[k][q] = s * kp + c * kq;
  }
  for (std::size_t k = 0; k < 4; ++k) {
    const double pk = n[p][k];
    const double qk = n[q][k];
    n[p][k] = c * pk - s * qk;
    n[q][k] = s * pk + c * qk;
  }
  n[p][q] = n[q][p] = 0.0;
  for (auto& v : vectors) {
    const double vp = v[p];
    const double vq = v[q];
    v[p] = c * vp - s * vq;
    v[q] = s * vp + c * vq;
  }
}

/// Unit eigenvector of the largest eigenvalue, the first of equal ones, so that F = 0 gives the identity.
std::array<double, 4> largest_eigenvector(Matrix4 n) {
  Matrix4 vectors{};
  for (std::size_t i = 0; i < 4; ++i) vectors[i][i] = 1.0;
  for (int sweep = 0; sweep < jacobi_sweeps; ++sweep) {
    bool turned = false;
    for (std::size_t p = 0; p < 3; ++p) {
      for (std::size_t q = p + 1; q < 4; ++q) {
        // The largest entry of F is 1, so entries below this are rounding.
        if (std::abs(n[p][q]) < 1e-17) continue;
        jacobi_rotation(n, vectors, p, q);
        turned = true;
      }
    }
    if (!turned) break;
  }
  std::size_t best = 0;
  for (std::size_t i = 1; i < 4; ++i) {
    if (n[i][i] > n[best][best]) best = i;
  }
  return {vectors[0][best], vectors[1][best], vectors[2][best], vectors[3][best]};
}

Matrix3 rotation_of(const std::array<double, 4>& q) {
  const auto [w, x, y, z] = q;
  const double s = 2.0 / (w * w + x * x + y * y + z * z);
  return {{1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), s * (x * y + w * z),
           1.0 - s * (x * x + z * z), s * (y * z - w * x), s * (x * z - w * y), s * (y * z + w * x),
           1.0 - s * (x * x + y * y)}};
}

}  // namespace

Matrix3 nearest_rotation(const Matrix3& f) {
  double scale = 0.0;
  for (const double value : f.values) {
    if (!std::isfinite(value)) return identity();
    scale = std::max(scale, std::abs(value));
  }
  if (scale == 0.0) return identity();
  Matrix3 scaled;
  for (std::size_t k = 0; k < 9; ++k) scaled.values[k] = f.values[k] / scale;
  if (determinant(scaled) > healthy_determinant) {
    if (const auto rotation = newton(scaled)) return *rotation;
  }
  return rotation_of(largest_eigenvector(quaternion_form(scaled)));
}

}  // namespace palpate::fem

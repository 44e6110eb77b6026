#include "fem/symmetric_eigen.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace palpate::fem {
namespace {

/// A matrix during diagonalisation, and the rotations so far: column k converges to the k-th eigenvector.
struct Rotated {
  Matrix3 a;
  Matrix3 v = identity();

  /// Rotates so that a(p, q) becomes zero.
  void rotate(int p, int q) {
    const double apq = a(p, q);
    if (apq == 0.0) return;
    const double theta = (a(q, q) - a(p, p)) / (2.0 * apq);
    // The smaller root of t^2 + 2 theta t - 1; 0 where theta is infinite.
    const double t = (theta >= 0.0 ? 1.0 : -1.0) / (std::abs(theta) + std::sqrt(theta * theta + 1.0));
    const double c = 1.0 / std::sqrt(t * t + 1.0);
    const double s = t * c;
    a(p, p) -= t * apq;
    a(q, q) += t * apq;
    a(p, q) = a(q, p) = 0.0;
    const int r = 3 - p - q;
    const double arp = a(r, p);
    const double arq = a(r, q);
    a(r, p) = a(p, r) = c * arp - s * arq;
    a(r, q) = a(q, r) = s * arp + c * arq;
    for (int k = 0; k < 3; ++k) {
      const double vkp = v(k, p);
      const double vkq = v(k, q);
      v(k, p) = c * vkp - s * vkq;
      v(k, q) = s * vkp + c * vkq;
    }
  }
};

Vec3 with_positive_largest(const Vec3& a) {
  double largest = a.x;
  if (std::abs(a.y) > std::abs(largest)) largest = a.y;
  if (std::abs(a.z) > std::abs(largest)) largest = a.z;
  return largest < 0.0 ? -a : a;
}

}  // namespace

SymmetricEigen symmetric_eigen(const SymmetricMatrix3& a) {
  const double size = std::max(
      {std::abs(a.xx), std::abs(a.yy), std::abs(a.zz), std::abs(a.xy), std::abs(a.xz), std::abs(a.yz)});
  const bool finite = std::isfinite(a.xx + a.yy + a.zz + a.xy + a.xz + a.yz);
  if (!finite) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    constexpr Vec3 nowhere{none, none, none};
    return {nowhere, {nowhere, nowhere, nowhere}};
  }
  if (size == 0.0) return {{}, {Vec3{1.0, 0.0, 0.0}, Vec3{0.0, 1.0, 0.0}, Vec3{0.0, 0.0, 1.0}}};
  // Scale the matrix, so that squares neither overflow nor underflow.
  Rotated m{.a = {{a.xx / size, a.xy / size, a.xz / size, a.xy / size, a.yy / size, a.yz / size, a.xz / size,
                   a.yz / size, a.zz / size}}};
  constexpr int most_sweeps = 32;  // convergence is quadratic: six suffice
  constexpr double rounding = 1e-18;
  for (int sweep = 0; sweep < most_sweeps; ++sweep) {
    if (std::abs(m.a(0, 1)) + std::abs(m.a(0, 2)) + std::abs(m.a(1, 2)) <= rounding) break;
    m.rotate(0, 1);
    m.rotate(0, 2);
    m.rotate(1, 2);
  }
  std::array<int, 3> order{0, 1, 2};
  const auto sort_two = [&](std::size_t i, std::size_t j) {
    if (m.a(order[i], order[i]) < m.a(order[j], order[j])) std::swap(order[i], order[j]);
  };
  sort_two(0, 1);
  sort_two(1, 2);
  sort_two(0, 1);
  SymmetricEigen result;
  result.values = {size * m.a(order[0], order[0]), size * m.a(order[1], order[1]),
                   size * m.a(order[2], order[2])};
  for (std::size_t k = 0; k < 3; ++k) {
    const int column = order[k];
    result.vectors[k] = with_positive_largest({m.v(0, column), m.v(1, column), m.v(2, column)});
  }
  return result;
}

SymmetricMatrix3 positive_part(const SymmetricEigen& eigen, double kept) {
  const std::array values{eigen.values.x, eigen.values.y, eigen.values.z};
  SymmetricMatrix3 sum;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& v = eigen.vectors[k];
    sum = sum + std::max(values[k], -kept * values[k]) *
                    SymmetricMatrix3{v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z};
  }
  return sum;
}

}  // namespace palpate::fem

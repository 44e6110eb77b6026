#pragma once

#include <array>
#include <cstddef>

#include <palpate/types.hpp>

#include "geometry/vector.hpp"

namespace palpate::fem {

/// A 3x3 matrix, row by row; zero by default.
struct Matrix3 {
  std::array<double, 9> values{};

  constexpr double& operator()(int row, int column) {
    return values[static_cast<std::size_t>(3 * row + column)];
  }
  constexpr double operator()(int row, int column) const {
    return values[static_cast<std::size_t>(3 * row + column)];
  }
  friend bool operator==(const Matrix3&, const Matrix3&) = default;
};

/// A symmetric 3x3 matrix; zero by default.
struct SymmetricMatrix3 {
  double xx = 0.0;
  double yy = 0.0;
  double zz = 0.0;
  double xy = 0.0;
  double xz = 0.0;
  double yz = 0.0;
  friend bool operator==(const SymmetricMatrix3&, const SymmetricMatrix3&) = default;
};

constexpr Matrix3 identity() {
  return {{1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}};
}

constexpr Vec3 operator*(const Matrix3& a, const Vec3& x) {
  const auto& m = a.values;
  return {m[0] * x.x + m[1] * x.y + m[2] * x.z, m[3] * x.x + m[4] * x.y + m[5] * x.z,
          m[6] * x.x + m[7] * x.y + m[8] * x.z};
}

constexpr Vec3 operator*(const SymmetricMatrix3& a, const Vec3& x) {
  return {a.xx * x.x + a.xy * x.y + a.xz * x.z, a.xy * x.x + a.yy * x.y + a.yz * x.z,
          a.xz * x.x + a.yz * x.y + a.zz * x.z};
}

constexpr SymmetricMatrix3 operator+(const SymmetricMatrix3& a, const SymmetricMatrix3& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}
constexpr SymmetricMatrix3 operator*(double s, const SymmetricMatrix3& a) {
  return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz};
}

constexpr Matrix3 operator-(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (std::size_t i = 0; i < 9; ++i) c.values[i] = a.values[i] - b.values[i];
  return c;
}

/// a += s x y^T.
constexpr void add_outer(Matrix3& a, double s, const Vec3& x, const Vec3& y) {
  a.values[0] += s * (x.x * y.x);
  a.values[1] += s * (x.x * y.y);
  a.values[2] += s * (x.x * y.z);
  a.values[3] += s * (x.y * y.x);
  a.values[4] += s * (x.y * y.y);
  a.values[5] += s * (x.y * y.z);
  a.values[6] += s * (x.z * y.x);
  a.values[7] += s * (x.z * y.y);
  a.values[8] += s * (x.z * y.z);
}

/// Sum of all products of equal entries, tr(a^T b).
constexpr double inner(const Matrix3& a, const Matrix3& b) {
  double s = 0.0;
  for (std::size_t i = 0; i < 9; ++i) s += a.values[i] * b.values[i];
  return s;
}

constexpr Vec3 row(const Matrix3& a, int i) {
  return {a(i, 0), a(i, 1), a(i, 2)};
}

/// The matrix of these rows.
constexpr Matrix3 from_rows(const Vec3& a, const Vec3& b, const Vec3& c) {
  return {{a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z}};
}

constexpr Matrix3 transposed(const Matrix3& a) {
  return {{a(0, 0), a(1, 0), a(2, 0), a(0, 1), a(1, 1), a(2, 1), a(0, 2), a(1, 2), a(2, 2)}};
}

/// a b^T
constexpr Matrix3 times_transposed(const Matrix3& a, const Matrix3& b) {
  Matrix3 c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) c(i, j) = dot(row(a, i), row(b, j));
  }
  return c;
}

/// a a^T
constexpr SymmetricMatrix3 outer_square(const Matrix3& a) {
  return {dot(row(a, 0), row(a, 0)), dot(row(a, 1), row(a, 1)), dot(row(a, 2), row(a, 2)),
          dot(row(a, 0), row(a, 1)), dot(row(a, 0), row(a, 2)), dot(row(a, 1), row(a, 2))};
}

constexpr double trace(const Matrix3& a) {
  return a(0, 0) + a(1, 1) + a(2, 2);
}

constexpr SymmetricMatrix3 symmetric_part(const Matrix3& a) {
  return {a(0, 0),
          a(1, 1),
          a(2, 2),
          0.5 * (a(0, 1) + a(1, 0)),
          0.5 * (a(0, 2) + a(2, 0)),
          0.5 * (a(1, 2) + a(2, 1))};
}

/// a^T b
constexpr Matrix3 transposed_times(const Matrix3& a, const Matrix3& b) {
  return times_transposed(transposed(a), transposed(b));
}

/// F of a displacement gradient F - I.
constexpr Matrix3 plus_identity(Matrix3 h) {
  for (int k = 0; k < 3; ++k) h(k, k) += 1.0;
  return h;
}

/// Cofactors of a: det(a) times the transpose of its inverse.
constexpr Matrix3 cofactors(const Matrix3& a) {
  return from_rows(cross(row(a, 1), row(a, 2)), cross(row(a, 2), row(a, 0)), cross(row(a, 0), row(a, 1)));
}

constexpr double determinant(const Matrix3& a) {
  return dot(row(a, 0), cross(row(a, 1), row(a, 2)));
}

/// Inverse; its entries are not finite where a is singular up to rounding.
constexpr Matrix3 inverse(const Matrix3& a) {
  const Matrix3 c = cofactors(a);
  const double d = dot(row(a, 0), row(c, 0));
  return {{c(0, 0) / d, c(1, 0) / d, c(2, 0) / d, c(0, 1) / d, c(1, 1) / d, c(2, 1) / d, c(0, 2) / d,
           c(1, 2) / d, c(2, 2) / d}};
}

}  // namespace palpate::fem

#pragma once

#include <array>
#include <boost/multiprecision/cpp_int.hpp>

#include <palpate/types.hpp>

/// Geometry in rational arithmetic: the oracle of the exact predicates. Nothing here shares a formula with
/// src/: points are located by solving the linear system for barycentric or ray parameters with Cramer's
/// rule, not by orientation signs.
namespace palpate::test {

using Rational = boost::multiprecision::cpp_rational;
using RationalVec = std::array<Rational, 3>;

inline RationalVec rational(const Vec3& p) {
  return {Rational(p.x), Rational(p.y), Rational(p.z)};
}
inline RationalVec minus(const RationalVec& a, const RationalVec& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Rational determinant(const RationalVec& u, const RationalVec& v, const RationalVec& w) {
  return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
         u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// Solves u x + v y + w z = r; false if the columns are dependent.
inline bool solve(const RationalVec& u, const RationalVec& v, const RationalVec& w, const RationalVec& r,
                  RationalVec& solution) {
  const Rational d = determinant(u, v, w);
  if (d == 0) return false;
  solution = {determinant(r, v, w) / d, determinant(u, r, w) / d, determinant(u, v, r) / d};
  return true;
}

inline bool rational_point_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const RationalVec o = rational(a);
  RationalVec x;
  if (!solve(minus(rational(b), o), minus(rational(c), o), minus(rational(d), o), minus(rational(p), o), x)) {
    return false;
  }
  return x[0] >= 0 && x[1] >= 0 && x[2] >= 0 && x[0] + x[1] + x[2] <= 1;
}

/// Where the segment (a, b) meets the triangle, as a parameter in [0, 1]; false where it does not or lies in
/// its plane.
inline bool rational_crossing(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                              Rational& parameter) {
  // t0 + s (t1 - t0) + r (t2 - t0) = a + t (b - a)
  const RationalVec o = rational(t0);
  RationalVec x;
  if (!solve(minus(rational(t1), o), minus(rational(t2), o), minus(rational(a), rational(b)),
             minus(rational(a), o), x)) {
    return false;
  }
  parameter = x[2];
  return x[0] >= 0 && x[1] >= 0 && x[0] + x[1] <= 1 && x[2] >= 0 && x[2] <= 1;
}

}  // namespace palpate::test

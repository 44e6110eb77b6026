#pragma once

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>

#include <palpate/types.hpp>

/// Geometry in rational arithmetic: the oracle of the exact predicates. Nothing here shares a formula with
/// src/: points are located by solving the linear system for barycentric or ray parameters with Cramer's
/// rule, not by orientation signs.
namespace palpate::test {

using Rational = boost::multiprecision::cpp_rational;
using RationalVec = std::array<Rational, 3>;
using Integer = boost::multiprecision::cpp_int;
using IntegerVec = std::array<Integer, 3>;

inline RationalVec rational(const Vec3& p) {
  return {Rational(p.x), Rational(p.y), Rational(p.z)};
}
template <class Number>
std::array<Number, 3> minus(const std::array<Number, 3>& a, const std::array<Number, 3>& b) {
  return {Number(a[0] - b[0]), Number(a[1] - b[1]), Number(a[2] - b[2])};
}
template <class Number>
Number determinant(const std::array<Number, 3>& u, const std::array<Number, 3>& v,
                   const std::array<Number, 3>& w) {
  return u[0] * (v[1] * w[2] - v[2] * w[1]) - u[1] * (v[0] * w[2] - v[2] * w[0]) +
         u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/// The points with all coordinates multiplied by one power of two, so that they are integers. Rational
/// numbers need a greatest common divisor in each operation, integers do not.
template <std::size_t N>
std::array<IntegerVec, N> scaled_to_integers(const std::array<Vec3, N>& points) {
  constexpr int bits = std::numeric_limits<double>::digits - 1;
  int lowest = std::numeric_limits<int>::max();
  for (const Vec3& p : points) {
    for (const double x : {p.x, p.y, p.z})
      if (x != 0.0) lowest = std::min(lowest, std::ilogb(x) - bits);
  }
  const auto scaled = [&](double x) {
    if (x == 0.0) return Integer(0);
    const int exponent = std::ilogb(x) - bits;
    return Integer(Integer(static_cast<long long>(std::scalbn(x, -exponent))) *
                   boost::multiprecision::pow(Integer(2), static_cast<unsigned>(exponent - lowest)));
  };
  std::array<IntegerVec, N> result;
  for (std::size_t i = 0; i < N; ++i)
    result[i] = {scaled(points[i].x), scaled(points[i].y), scaled(points[i].z)};
  return result;
}

/// Solves u x + v y + w z = r: the solution is x[i] / denominator, with denominator >= 0. It is 0 if the
/// columns are dependent.
struct CramersRule {
  CramersRule(const IntegerVec& u, const IntegerVec& v, const IntegerVec& w, const IntegerVec& r)
      : x{determinant(r, v, w), determinant(u, r, w), determinant(u, v, r)},
        denominator(determinant(u, v, w)) {
    if (denominator > 0) return;
    denominator = -denominator;
    for (Integer& numerator : x) numerator = -numerator;
  }
  IntegerVec x;
  Integer denominator;
};

inline bool rational_point_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const auto [q, o, u, v, w] = scaled_to_integers<5>({p, a, b, c, d});
  const CramersRule s(minus(u, o), minus(v, o), minus(w, o), minus(q, o));
  return s.denominator != 0 && s.x[0] >= 0 && s.x[1] >= 0 && s.x[2] >= 0 &&
         s.x[0] + s.x[1] + s.x[2] <= s.denominator;
}

/// Where the segment (a, b) meets the triangle, as a parameter in [0, 1]; false where it does not or lies in
/// its plane.
inline bool rational_crossing(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2,
                              Rational& parameter) {
  // t0 + s (t1 - t0) + r (t2 - t0) = a + t (b - a)
  const auto [from, to, o, u, v] = scaled_to_integers<5>({a, b, t0, t1, t2});
  const CramersRule s(minus(u, o), minus(v, o), minus(from, to), minus(from, o));
  const Integer& most = s.denominator;
  if (most == 0 || s.x[0] < 0 || s.x[1] < 0 || s.x[0] + s.x[1] > most || s.x[2] < 0 || s.x[2] > most)
    return false;
  parameter = Rational(s.x[2], most);
  return true;
}

}  // namespace palpate::test

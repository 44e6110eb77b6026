#include "geometry/predicates.hpp"

#include <algorithm>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "geometry/expansion.hpp"
#include "geometry/vector.hpp"
#include "simd/crossing_parameters.hpp"

namespace palpate {
namespace {

namespace mp = boost::multiprecision;
// For coordinates so large or small that expansions of doubles are not exact.
using Integer = mp::number<mp::cpp_int_backend<512>, mp::et_off>;

/// A 3x3 determinant in double with a bound on its absolute error.
struct Filtered {
  double value;
  double error;
};

Filtered orient3d_filtered(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = d - a;
  const double vxwy = v.x * w.y;
  const double vywx = v.y * w.x;
  const double wxuy = w.x * u.y;
  const double wyux = w.y * u.x;
  const double uxvy = u.x * v.y;
  const double uyvx = u.y * v.x;
  const double value = u.z * (vxwy - vywx) + v.z * (wxuy - wyux) + w.z * (uxvy - uyvx);
  const double permanent = std::abs(u.z) * (std::abs(vxwy) + std::abs(vywx)) +
                           std::abs(v.z) * (std::abs(wxuy) + std::abs(wyux)) +
                           std::abs(w.z) * (std::abs(uxvy) + std::abs(uyvx));
  using Bound = simd::OrientationBound;
  // The error of a product that underflows is below the smallest normal number; it is then multiplied by a z
  // difference.
  const double underflow = Bound::tiny * (4.0 + std::abs(u.z) + std::abs(v.z) + std::abs(w.z));
  return {value, Bound::relative * permanent + underflow};
}

using Volume = Expansion<192>;

/// det[b - a, c - a, d - a], exactly. None where doubles have too few exponents for it.
std::optional<Volume> volume_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  using Row = std::array<Expansion<2>, 3>;
  const auto from_a = [&a](const Vec3& p) {
    return Row{difference(p.x, a.x), difference(p.y, a.y), difference(p.z, a.z)};
  };
  const std::array<Row, 3> rows{from_a(b), from_a(c), from_a(d)};
  for (const Row& row : rows)
    if (!std::ranges::all_of(row, is_in_range)) return {};
  const auto minor = [](const Row& v, const Row& w) {
    Expansion<8> less = product(v[1], w[0]);
    less.negate();
    return sum(product(v[0], w[1]), less);
  };
  const auto& [u, v, w] = rows;
  return sum(sum(product(minor(v, w), u[2]), product(minor(w, u), v[2])), product(minor(u, v), w[2]));
}

/// Mantissa and exponent of a finite double: mantissa * 2^exponent.
struct Scaled {
  std::int64_t mantissa;
  int exponent;
};

Scaled scaled(double x) {
  if (x == 0.0) return {0, std::numeric_limits<int>::max()};
  int exponent = 0;
  const double fraction = std::frexp(x, &exponent);
  return {static_cast<std::int64_t>(std::ldexp(fraction, 53)), exponent - 53};
}

/// det[b - a, c - a, d - a] times a positive power of two, exactly. Calls whose results are compared must use
/// the same `exponent`.
Integer exact_determinant(const std::array<Vec3, 4>& corners, int exponent) {
  const auto integer = [exponent](double x) {
    const Scaled s = scaled(x);
    Integer i = s.mantissa;
    if (s.mantissa != 0) i <<= s.exponent - exponent;
    return i;
  };
  std::array<std::array<Integer, 3>, 4> p;
  for (std::size_t i = 0; i < 4; ++i) {
    p[i] = {integer(corners[i].x), integer(corners[i].y), integer(corners[i].z)};
  }
  std::array<std::array<Integer, 3>, 3> m;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) m[i][k] = p[i + 1][k] - p[0][k];
  }
  const auto& [u, v, w] = m;
  return u[2] * (v[0] * w[1] - v[1] * w[0]) + v[2] * (w[0] * u[1] - w[1] * u[0]) +
         w[2] * (u[0] * v[1] - u[1] * v[0]);
}

/// The smallest exponent of the coordinates: with it all become integers.
template <std::size_t n>
int common_exponent(const std::array<Vec3, n>& points) {
  int exponent = std::numeric_limits<int>::max();
  for (const Vec3& p : points) {
    for (const double x : {p.x, p.y, p.z}) exponent = std::min(exponent, scaled(x).exponent);
  }
  return exponent;
}

/// numerator / denominator of positive integers of any length (the numerator may be zero), to the last bits
/// of a double.
double ratio(const Integer& numerator, const Integer& denominator) {
  // Numbers too large for a double lose low bits of both: no more than 2^-900 of the denominator.
  const int excess = std::max(0, static_cast<int>(mp::msb(denominator)) - 900);
  Integer n = numerator;
  Integer d = denominator;
  n >>= excess;
  d >>= excess;
  return n.convert_to<double>() / d.convert_to<double>();
}

double determinant(const Vec3& u, const Vec3& v, const Vec3& w) {
  return dot(u, cross(v, w));
}

struct Likely {
  bool is_certain;
  bool meets;
};

double largest_coordinate(const Vec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// segment_meets_triangle() where the rounding errors of the five volumes leave no doubt. All are computed
/// from the same differences: those of b and of the corners from a.
Likely segment_meets_triangle_filtered(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1,
                                       const Vec3& t2) {
  const Vec3 d = b - a;
  const Vec3 u = t0 - a;
  const Vec3 v = t1 - a;
  const Vec3 w = t2 - a;
  const Vec3 vw = cross(v, w);
  const double sides[3] = {dot(d, cross(u, v)), dot(d, vw), dot(d, cross(w, u))};
  const double of_a = dot(u, vw);
  const double of_b = of_a - (sides[0] + sides[1] + sides[2]);
  // Each of the four volumes has a permanent of at most 6 size^3. The last one adds their errors, of 24
  // size^3 times the relative bound, and those of three sums, of less than 11 size^3 times it.
  const double size =
      std::max({largest_coordinate(d), largest_coordinate(u), largest_coordinate(v), largest_coordinate(w)});
  using Bound = simd::OrientationBound;
  const double error = 40.0 * Bound::relative * (size * size * size) + 64.0 * Bound::tiny * (1.0 + size);
  const bool ends_certain = std::abs(of_a) > error && std::abs(of_b) > error;
  if (ends_certain && (of_a > 0.0) == (of_b > 0.0)) return {true, false};
  const auto [least, most] = std::minmax({sides[0], sides[1], sides[2]});
  if (least < -error && most > error) return {true, false};
  const bool sides_certain = least > error || most < -error;
  return {ends_certain && sides_certain, true};
}

}  // namespace

int orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Filtered f = orient3d_filtered(a, b, c, d);
  if (f.value > f.error) return 1;
  if (-f.value > f.error) return -1;
  if (const auto volume = volume_of(a, b, c, d)) return volume->sign();
  const std::array<Vec3, 4> corners{a, b, c, d};
  return exact_determinant(corners, common_exponent(corners)).sign();
}

bool point_in_tet(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  // Replacing one corner by p must never change the orientation of the tet. All signs zero means that the tet
  // has no volume.
  bool positive = false;
  bool negative = false;
  const auto has_both_signs = [&](int sign) {
    positive |= sign > 0;
    negative |= sign < 0;
    return positive && negative;
  };
  if (has_both_signs(orient3d(p, b, c, d)) || has_both_signs(orient3d(a, p, c, d)) ||
      has_both_signs(orient3d(a, b, p, d)) || has_both_signs(orient3d(a, b, c, p))) {
    return false;
  }
  // The four volumes add up to that of the tet. So p is inside if all have one sign or are zero, and one is
  // not zero.
  return positive || negative;
}

bool segment_meets_triangle(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  const Likely likely = segment_meets_triangle_filtered(a, b, t0, t1, t2);
  if (likely.is_certain) return likely.meets;
  const int side_a = orient3d(t0, t1, t2, a);
  const int side_b = orient3d(t0, t1, t2, b);
  if (side_a == side_b) return false;  // both on one side, or (0, 0): both in the plane
  bool positive = false;
  bool negative = false;
  for (const int sign : {orient3d(a, b, t0, t1), orient3d(a, b, t1, t2), orient3d(a, b, t2, t0)}) {
    positive |= sign > 0;
    negative |= sign < 0;
  }
  return !(positive && negative);
}

double crossing_parameter(const Vec3& a, const Vec3& b, const Vec3& t0, const Vec3& t1, const Vec3& t2) {
  // The ends are on different sides, or one is in the plane, so the absolute distances from the plane add up.
  const auto distance = [&](const Vec3& end) -> std::optional<double> {
    const Filtered filtered = orient3d_filtered(t0, t1, t2, end);
    if (filtered.error < simd::parameter_accuracy * std::abs(filtered.value)) return std::abs(filtered.value);
    const std::optional<Volume> volume = volume_of(t0, t1, t2, end);
    return volume ? std::optional(std::abs(volume->value())) : std::nullopt;
  };
  if (const std::optional<double> of_a = distance(a)) {
    if (const std::optional<double> of_b = distance(b)) return *of_a / (*of_a + *of_b);
  }
  const int exponent = common_exponent(std::array<Vec3, 5>{a, b, t0, t1, t2});
  const Integer to_a = mp::abs(exact_determinant({t0, t1, t2, a}, exponent));
  const Integer to_b = mp::abs(exact_determinant({t0, t1, t2, b}, exponent));
  return std::clamp(ratio(to_a, to_a + to_b), 0.0, 1.0);
}

std::array<double, 4> barycentric_weights(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c,
                                          const Vec3& d) {
  // Offsets from p, so that the weights are accurate where p is near a corner or the tet is far from the
  // origin.
  const Vec3 pa = a - p;
  const Vec3 pb = b - p;
  const Vec3 pc = c - p;
  const Vec3 pd = d - p;
  std::array<double, 4> w{determinant(pb, pc, pd), -determinant(pa, pc, pd), determinant(pa, pb, pd),
                          -determinant(pa, pb, pc)};
  const double orientation = determinant(b - a, c - a, d - a) < 0.0 ? -1.0 : 1.0;
  double sum = 0.0;
  for (double& x : w) sum += x = std::max(0.0, orientation * x);
  if (!(sum > 0.0)) {  // a sliver whose volumes all round to zero: rounding cannot distinguish its points
    return {0.25, 0.25, 0.25, 0.25};
  }
  for (double& x : w) x /= sum;
  return w;
}

}  // namespace palpate

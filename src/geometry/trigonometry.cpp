#include "geometry/trigonometry.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

/// pi / 2 and pi minus their values rounded to double.
constexpr double half_pi_rest = 0x1.1a62633145c07p-54;
constexpr double pi_rest = 2.0 * half_pi_rest;

/// An angle minus the nearest multiple of pi / 2, as the unevaluated sum of two doubles.
struct Reduced {
  double head = 0.0;
  double tail = 0.0;         ///< below half a unit in the last place of the head
  std::int64_t quarter = 0;  ///< the multiple
};

/// Argument reduction with pi / 2 in three parts (Cody & Waite 1980). The first two have 33 bits, so that
/// their products with numbers of up to 20 bits are exact.
Reduced reduced(double angle) {
  constexpr double most = 0x1p20;
  constexpr std::array part{0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};
  if (!(std::abs(angle) <= most)) angle = std::fmod(angle, 2.0 * std::numbers::pi);  // exact
  const double quarter_turns = angle * (2.0 / std::numbers::pi);
  const auto quarter = static_cast<std::int64_t>(quarter_turns + (quarter_turns < 0.0 ? -0.5 : 0.5));
  const auto n = static_cast<double>(quarter);
  const double a = angle - n * part[0];
  const double b = n * part[1];
  const double first = a - b;
  // The rounding error of this difference (Knuth's TwoSum).
  const double back = first - a;
  const double lost = (a - (first - back)) - (b + back);
  const double second = lost - n * part[2];
  const double head = first + second;
  return {head, (first - head) + second, quarter};
}

/// Taylor polynomial; truncation error below 1e-19 of the result.
double sine_of(const Reduced& r) {
  constexpr std::array c{-1.0 / 6.0,        1.0 / 120.0,        -1.0 / 5040.0,       1.0 / 362880.0,
                         -1.0 / 39916800.0, 1.0 / 6227020800.0, -1.0 / 1307674368e3, 1.0 / 355687428096e3};
  const double z = r.head * r.head;
  double sum = c.back();
  for (std::size_t i = c.size() - 1; i-- > 0;) sum = sum * z + c[i];
  return r.head + (z * r.head * sum + r.tail * (1.0 - 0.5 * z));
}

double cosine_of(const Reduced& r) {
  constexpr std::array c{1.0 / 24.0,          -1.0 / 720.0,          1.0 / 40320.0,
                         -1.0 / 3628800.0,    1.0 / 479001600.0,     -1.0 / 87178291200.0,
                         1.0 / 20922789888e3, -1.0 / 6402373705728e3};
  const double z = r.head * r.head;
  double sum = c.back();
  for (std::size_t i = c.size() - 1; i-- > 0;) sum = sum * z + c[i];
  const double half = 0.5 * z;
  const double most = 1.0 - half;
  return most + (((1.0 - most) - half) + (z * z * sum - r.head * r.tail));
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

double sine(double angle) {
  if (!std::isfinite(angle)) return nan;
  const Reduced r = reduced(angle);
  const double size = (r.quarter & 1) == 0 ? sine_of(r) : cosine_of(r);
  return (r.quarter & 2) == 0 ? size : -size;
}

double cosine(double angle) {
  if (!std::isfinite(angle)) return nan;
  const Reduced r = reduced(angle);
  const double size = (r.quarter & 1) == 0 ? cosine_of(r) : sine_of(r);
  return ((r.quarter + 1) & 2) == 0 ? size : -size;
}

double arc_tangent(double y, double x) {
  // The arc tangents of 0, 1/8, ..., 1.
  constexpr std::array<double, 9> known{0.0,
                                        0x1.fd5ba9aac2f6ep-4,
                                        0x1.f5b75f92c80ddp-3,
                                        0x1.6f61941e4def1p-2,
                                        0x1.dac670561bb4fp-2,
                                        0x1.1e00babdefeb4p-1,
                                        0x1.4978fa3269ee1p-1,
                                        0x1.700a7c5784634p-1,
                                        0x1.921fb54442d18p-1};
  constexpr std::array c{-1.0 / 3.0, 1.0 / 5.0, -1.0 / 7.0, 1.0 / 9.0, -1.0 / 11.0, 1.0 / 13.0};
  const double less = std::min(std::abs(x), std::abs(y));
  const double more = std::max(std::abs(x), std::abs(y));
  const double t = more > 0.0 ? less / more : 0.0;
  const auto nearest = static_cast<std::size_t>((16.0 * t + 1.0) / 2.0);
  const double base = 0.125 * static_cast<double>(nearest);
  const double u = (t - base) / (1.0 + base * t);  // |u| <= 1/16: relative truncation error below 1e-18
  const double z = u * u;
  double sum = c.back();
  for (std::size_t i = c.size() - 1; i-- > 0;) sum = sum * z + c[i];
  double angle = known[nearest] + (u + u * z * sum);
  if (std::abs(y) > std::abs(x)) angle = 0.5 * std::numbers::pi - (angle - half_pi_rest);
  if (x < 0.0) angle = std::numbers::pi - (angle - pi_rest);
  return std::copysign(angle, y);
}

double arc_sine(double x) {
  return arc_tangent(x, std::sqrt((1.0 - x) * (1.0 + x)));
}

double arc_cosine(double x) {
  return arc_tangent(std::sqrt((1.0 - x) * (1.0 + x)), x);
}

}  // namespace palpate

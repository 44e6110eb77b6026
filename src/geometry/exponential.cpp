#include "geometry/exponential.hpp"

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>

namespace palpate {
namespace {

/// ln 2 in two parts; the first has 32 bits, so that its products with exponents are exact (Cody & Waite
/// 1980).
constexpr double ln2_head = 0x1.62e42feep-1;
constexpr double ln2_tail = 0x1.a39ef35793c76p-33;

}  // namespace

double exponential(double x) {
  if (std::isnan(x)) return x;
  if (x < -708.0) return 0.0;
  if (x > 709.0) return std::numeric_limits<double>::infinity();
  const double halves = x / std::numbers::ln2;
  const int n = static_cast<int>(halves + (halves < 0.0 ? -0.5 : 0.5));
  const double r = (x - n * ln2_head) - n * ln2_tail;
  // Taylor polynomial for |r| <= ln(2) / 2; truncation error below 1e-17.
  constexpr std::array c{1.0 / 2.0,       1.0 / 6.0,        1.0 / 24.0,        1.0 / 120.0,
                         1.0 / 720.0,     1.0 / 5040.0,     1.0 / 40320.0,     1.0 / 362880.0,
                         1.0 / 3628800.0, 1.0 / 39916800.0, 1.0 / 479001600.0, 1.0 / 6227020800.0};
  double sum = c.back();
  for (std::size_t i = c.size() - 1; i-- > 0;) sum = sum * r + c[i];
  return std::ldexp(1.0 + (r + r * r * sum), n);
}

double log_of_one_plus(double x) {
  if (!(x > -1.0) || !std::isfinite(x)) return std::numeric_limits<double>::quiet_NaN();
  constexpr double least = 0.5 * std::numbers::sqrt2;
  double z = x / (2.0 + x);
  int n = 0;
  if (1.0 + x < least || 1.0 + x > std::numbers::sqrt2) {
    double m = std::frexp(1.0 + x, &n);
    if (m < least) {
      m *= 2.0;
      --n;
    }
    z = (m - 1.0) / (m + 1.0);
  }
  // 2 artanh(z), |z| < 0.1716; truncation error below 1e-17.
  const double square = z * z;
  double sum = 0.0;
  for (int k = 21; k > 1; k -= 2) sum = square * (sum + 1.0 / k);
  const double rest = 2.0 * (z + z * sum);
  return n * ln2_head + (n * ln2_tail + rest);
}

}  // namespace palpate

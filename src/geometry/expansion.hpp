#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

/// Exact sums of doubles (Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric
/// predicates", 1997). All is exact as long as no operation overflows and no rounding error underflows: see
/// is_in_range().
namespace palpate {

/// A sum of doubles that do not overlap, in increasing order of their absolute values; none of them is zero.
template <std::size_t most>
class Expansion {
 public:
  void add_if_not_zero(double term) {
    if (term != 0.0) terms_[size_++] = term;
  }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double operator[](std::size_t i) const { return terms_[i]; }
  [[nodiscard]] const double* begin() const { return terms_.data(); }
  [[nodiscard]] const double* end() const { return terms_.data() + size_; }
  /// Sign of the sum: that of its largest term.
  [[nodiscard]] int sign() const {
    if (size_ == 0) return 0;
    return terms_[size_ - 1] > 0.0 ? 1 : -1;
  }
  /// The sum with a relative error of about 1e-16.
  [[nodiscard]] double value() const {
    double sum = 0.0;
    for (const double term : *this) sum += term;
    return sum;
  }
  void negate() {
    for (std::size_t i = 0; i < size_; ++i) terms_[i] = -terms_[i];
  }

 private:
  std::array<double, most> terms_;  // the first size_ are set
  std::size_t size_ = 0;
};

/// A rounded result and its rounding error.
struct Rounded {
  double value;
  double error;
};

/// a + b.
inline Rounded two_sum(double a, double b) {
  const double sum = a + b;
  const double of_b = sum - a;
  return {sum, (a - (sum - of_b)) + (b - of_b)};
}

/// a * b. Without a fused multiply-add, which not all processors have (Dekker 1971).
inline Rounded two_product(double a, double b) {
  constexpr double splitter = 0x1p27 + 1.0;
  const auto high = [](double x) {
    const double c = splitter * x;
    return c - (c - x);
  };
  const double product = a * b;
  const double a_high = high(a);
  const double b_high = high(b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  return {product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)};
}

inline Expansion<2> difference(double a, double b) {
  const Rounded d = two_sum(a, -b);
  Expansion<2> result;
  result.add_if_not_zero(d.error);
  result.add_if_not_zero(d.value);
  return result;
}

template <std::size_t m, std::size_t n>
Expansion<m + n> sum(const Expansion<m>& a, const Expansion<n>& b) {
  Expansion<m + n> result;
  const double* p = a.begin();
  const double* q = b.begin();
  double rest = 0.0;
  while (p != a.end() || q != b.end()) {
    const bool from_a = q == b.end() || (p != a.end() && std::abs(*p) < std::abs(*q));
    const Rounded next = two_sum(rest, from_a ? *p++ : *q++);
    result.add_if_not_zero(next.error);
    rest = next.value;
  }
  result.add_if_not_zero(rest);
  return result;
}

template <std::size_t n>
Expansion<2 * n> product(const Expansion<n>& a, double b) {
  Expansion<2 * n> result;
  double rest = 0.0;
  for (const double term : a) {
    const Rounded p = two_product(term, b);
    const Rounded low = two_sum(rest, p.error);
    const Rounded high = two_sum(p.value, low.value);
    result.add_if_not_zero(low.error);
    result.add_if_not_zero(high.error);
    rest = high.value;
  }
  result.add_if_not_zero(rest);
  return result;
}

template <std::size_t n>
Expansion<4 * n> product(const Expansion<n>& a, const Expansion<2>& b) {
  Expansion<2 * n> low;
  Expansion<2 * n> high;
  if (b.size() > 0) low = product(a, b[0]);
  if (b.size() > 1) high = product(a, b[1]);
  return sum(low, high);
}

/// Whether products of three such expansions, and all their rounding errors, are neither too large nor too
/// small for doubles.
inline bool is_in_range(const Expansion<2>& a) {
  return std::all_of(a.begin(), a.end(),
                     [](double x) { return std::abs(x) > 0x1p-300 && std::abs(x) < 0x1p300; });
}

}  // namespace palpate

// Oracles: the functions to 50 decimal digits (Boost.Multiprecision); for the bits a hash that every compiler
// must reproduce.
#include "geometry/trigonometry.hpp"

#include <bit>
#include <boost/multiprecision/cpp_dec_float.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <vector>

#include "support/random.hpp"

namespace palpate {
namespace {

using Exact = boost::multiprecision::cpp_dec_float_50;

/// Error in units in the last place of the exact value.
double error_of(double found, const Exact& exact) {
  const auto value = std::abs(static_cast<double>(exact));
  const double unit = std::nextafter(value, INFINITY) - value;
  return std::abs(static_cast<double>((Exact(found) - exact) / unit));
}

/// Uniform in [-1, 1), without distributions of the standard library, which differ.
double unit(test::Random& random) {
  return std::ldexp(static_cast<double>(random.word() >> 11U), -52) - 1.0;
}

/// Angles of all sizes, and around multiples of pi / 4.
std::vector<double> angles() {
  test::Random random(11);
  std::vector<double> all{0.0, 1e-300, 1e-9, 0.5, 1.0, std::numbers::pi, 0.5 * std::numbers::pi, 1048576.0};
  for (int i = 0; i < 4000; ++i) {
    all.push_back(7.0 * unit(random));
    const double wide = unit(random);
    all.push_back(std::ldexp(wide, static_cast<int>(random.word() % 61) - 40));
    const double angle = std::floor(6e5 * unit(random)) * (0.25 * std::numbers::pi);
    all.push_back(angle);
    all.push_back(angle + 1e-6 * unit(random));
  }
  return all;
}

double worst_of(const std::function<double(double)>& of) {
  double worst = 0.0;
  for (const double angle : angles()) worst = std::max(worst, of(angle));
  return worst;
}

TEST(Trigonometry, SineAndCosineAreRightToAUnitInTheLastPlace) {
  EXPECT_LT(worst_of([](double a) { return a == 0.0 ? 0.0 : error_of(sine(a), sin(Exact(a))); }), 1.0);
  EXPECT_LT(worst_of([](double a) { return error_of(cosine(a), cos(Exact(a))); }), 1.0);
  EXPECT_EQ(sine(0.0), 0.0);
  EXPECT_EQ(cosine(0.0), 1.0);
  EXPECT_EQ(sine(0.5 * std::numbers::pi), 1.0);
}

TEST(Trigonometry, FarAnglesAreRightToTheirOwnRounding) {
  for (const double angle : {0x1.8p21, 1e9, -3.3e12}) {
    EXPECT_NEAR(sine(angle), static_cast<double>(sin(Exact(angle))), 0x1p-53 * std::abs(angle)) << angle;
    EXPECT_NEAR(cosine(angle), static_cast<double>(cos(Exact(angle))), 0x1p-53 * std::abs(angle)) << angle;
  }
  for (const double angle : {std::numeric_limits<double>::infinity(), std::nan("")}) {
    EXPECT_TRUE(std::isnan(sine(angle)));
    EXPECT_TRUE(std::isnan(cosine(angle)));
  }
}

TEST(Trigonometry, ArcsAreRightToAFewUnits) {
  test::Random random(12);
  double tangents = 0.0;
  double sines = 0.0;
  double cosines = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const double x = unit(random) * std::ldexp(1.0, random.integer(-30, 3));
    const double y = unit(random) * std::ldexp(1.0, random.integer(-30, 3));
    tangents = std::max(tangents, error_of(arc_tangent(y, x), atan2(Exact(y), Exact(x))));
    const double s = i % 2 == 0 ? unit(random) : 1.0 - std::ldexp(1.0, -random.integer(1, 52));
    sines = std::max(sines, error_of(arc_sine(s), asin(Exact(s))));
    cosines = std::max(cosines, error_of(arc_cosine(s), acos(Exact(s))));
  }
  EXPECT_LT(tangents, 3.0);
  EXPECT_LT(sines, 5.0);
  EXPECT_LT(cosines, 5.0);
}

TEST(Trigonometry, ArcsOfTheAxes) {
  EXPECT_EQ(arc_tangent(0.0, 0.0), 0.0);
  EXPECT_EQ(arc_tangent(0.0, 2.0), 0.0);
  EXPECT_EQ(arc_tangent(3.0, 0.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(arc_tangent(-3.0, 0.0), -0.5 * std::numbers::pi);
  EXPECT_EQ(arc_tangent(0.0, -1.0), std::numbers::pi);
  EXPECT_EQ(arc_sine(1.0), 0.5 * std::numbers::pi);
  EXPECT_EQ(arc_cosine(1.0), 0.0);
  EXPECT_EQ(arc_cosine(-1.0), std::numbers::pi);
}

TEST(Trigonometry, BitsAreTheSameEverywhere) {
  std::uint64_t hash = 0;
  const auto add = [&](double value) { hash = hash * 0x100000001b3U ^ std::bit_cast<std::uint64_t>(value); };
  for (const double angle : angles()) {
    const double s = sine(angle);
    const double c = cosine(angle);
    for (const double value : {s, c, arc_tangent(s, c), arc_sine(s), arc_cosine(c)}) add(value);
  }
  EXPECT_EQ(hash, 0x921902e550f8e2dcU);
}

}  // namespace
}  // namespace palpate

// Exponential and logarithm against the C library's long double.
#include "geometry/exponential.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

namespace palpate {
namespace {

double relative(double ours, long double exact) {
  return static_cast<double>(std::abs((static_cast<long double>(ours) - exact) / exact));
}

TEST(Exponential, IsRightToRounding) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double worst = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double x = uniform(random) * (i % 2 == 0 ? 700.0 : 1.0);
    worst = std::max(worst, relative(exponential(x), std::exp(static_cast<long double>(x))));
  }
  EXPECT_LT(worst, 2e-15);
  EXPECT_EQ(exponential(0.0), 1.0);
  EXPECT_EQ(exponential(-1e4), 0.0);
  EXPECT_TRUE(std::isinf(exponential(1e4)));
  EXPECT_TRUE(std::isnan(exponential(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Logarithm, IsRightToRounding) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  double worst = 0.0;
  for (int i = 0; i < 300000; ++i) {
    double x = 0.999 * uniform(random);
    if (i % 3 == 1) x *= 1e-9;
    if (i % 3 == 2) x = std::exp(300.0 * std::abs(uniform(random)));
    worst = std::max(worst, relative(log_of_one_plus(x), std::log1p(static_cast<long double>(x))));
  }
  EXPECT_LT(worst, 2e-15);
  EXPECT_EQ(log_of_one_plus(0.0), 0.0);
  EXPECT_TRUE(std::isnan(log_of_one_plus(-1.0)));
  EXPECT_TRUE(std::isnan(log_of_one_plus(std::numeric_limits<double>::infinity())));
}

}  // namespace
}  // namespace palpate

#pragma once

namespace palpate {

/// Exponential and logarithm for all code that changes the simulated state. Like trigonometry.hpp, they use
/// only operations that IEEE 754 rounds, in the order written. So every machine returns the same bits.

/// e^x; relative error below 2e-15 (tested). 0 below -708, infinite above 709; NaN for NaN.
[[nodiscard]] double exponential(double x);

/// ln(1 + x) for x > -1, also of small x; relative error below 2e-15 (tested). Where x is not > -1 or not
/// finite: NaN.
[[nodiscard]] double log_of_one_plus(double x);

}  // namespace palpate

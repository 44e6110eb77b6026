#pragma once

namespace palpate {

/// Trigonometric functions for all code that changes the simulated state. They use only additions,
/// multiplications, divisions and square roots, each rounded as IEEE 754 says, in the order written. So they
/// return the same bits with every compiler, C library and processor; those of <cmath> do not.

/// Sine of an angle in radians; error below 1 unit in the last place. Beyond 2^20 radians the angle has a
/// relative error of 2^-53 more. NaN for an angle that is not finite.
[[nodiscard]] double sine(double angle);
/// Cosine, with the same errors.
[[nodiscard]] double cosine(double angle);

/// The angle of (x, y) from the x-axis, in [-pi, pi]; error below 3 units in the last place. 0 if both are 0.
/// \param y,x  finite
[[nodiscard]] double arc_tangent(double y, double x);
/// The angle in [-pi/2, pi/2] with this sine; error below 5 units in the last place.
/// \param x  in [-1, 1]
[[nodiscard]] double arc_sine(double x);
/// The angle in [0, pi] with this cosine; error below 5 units in the last place.
[[nodiscard]] double arc_cosine(double x);

}  // namespace palpate

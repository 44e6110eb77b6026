#pragma once

namespace palpate {

/// Functions of angles on the way to a state. They are made of additions, multiplications, divisions and
/// roots alone, each rounded once and in the order written: the same bits from every compiler, C library and
/// processor, which those of <cmath> do not promise.

/// Sine of an angle in radians, to 1 unit in the last place. Beyond 2^20 radians as if the angle had been
/// rounded once more; NaN where it is not finite.
[[nodiscard]] double sine(double angle);
/// Its cosine, likewise.
[[nodiscard]] double cosine(double angle);

/// The angle, in [-pi, pi], of the direction (x, y) with the x-axis, to 3 units in the last place; 0 where
/// both are zero. \param y,x  finite
[[nodiscard]] double arc_tangent(double y, double x);
/// The angle in [-pi/2, pi/2] with this sine, to 5 units in the last place. \param x  in [-1, 1]
[[nodiscard]] double arc_sine(double x);
/// The angle in [0, pi] with this cosine, likewise.
[[nodiscard]] double arc_cosine(double x);

}  // namespace palpate

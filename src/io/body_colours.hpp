#pragma once

#include <array>
#include <cstddef>

#include <palpate/types.hpp>

namespace palpate::io {

/// Red, green and blue in sRGB, each in [0, 1].
using Colour = std::array<float, 3>;

inline Colour to_colour(const std::array<double, 3>& rgb) {
  return {static_cast<float>(rgb[0]), static_cast<float>(rgb[1]), static_cast<float>(rgb[2])};
}

/// The colour that a body has unless it is given one: six colours that can be distinguished with the usual
/// kinds of colour blindness (after Okabe & Ito 2008), repeated. None is close to the red of contact points.
inline Colour default_colour(Index body) {
  constexpr std::array<Colour, 6> colours{{{0.34F, 0.71F, 0.91F},    // sky blue
                                           {0.93F, 0.65F, 0.15F},    // orange
                                           {0.10F, 0.62F, 0.47F},    // bluish green
                                           {0.94F, 0.89F, 0.45F},    // yellow
                                           {0.12F, 0.45F, 0.70F},    // blue
                                           {0.80F, 0.60F, 0.74F}}};  // purple
  return colours[static_cast<std::size_t>(body) % colours.size()];
}

/// The colour of rigid bodies that have none, and of bodies without field values while others are coloured.
inline constexpr Colour neutral_colour{0.72F, 0.72F, 0.74F};

/// Where a body that a field colours has no value. `viewer/src/colours.ts` has the same.
inline constexpr Colour no_value_colour{0.92F, 0.92F, 0.93F};

}  // namespace palpate::io

#pragma once

#include <array>
#include <string>

#include "io/picture_image.hpp"

namespace palpate::io {

/// A colour scale from `least` (dark) to `most` (bright).
struct ColourScale {
  double most = 1.0;   ///< value of the brightest colour, above `least`; larger values have the same colour
  std::string label;   ///< of the legend, ASCII: "displacement, mm"
  double least = 0.0;  ///< value of the darkest colour; smaller values have the same colour
};

/// The smallest of 1, 1.5, 2, 2.5, 3, 4, 5, 6 and 8 times a power of ten that is not below a positive number;
/// 0 for others. Ends of scales that nobody chose are such numbers, in pictures and on the page.
double nice_above(double value);

/// The colour of a value: viridis (van der Walt & Smith 2015), whose brightness grows evenly, so that it can
/// be read with any colour blindness and in grey prints. Interpolated between eleven of its colours.
std::array<float, 3> scale_colour(double value, const ColourScale& scale);

/// Draws the scale into the right side of an image, with numbers at both ends and in the middle. `bottom`
/// rows of the image are left free. Throws Error if the font cannot be drawn.
void draw_scale(Image& image, const ColourScale& scale, int bottom);

}  // namespace palpate::io

#pragma once

#include <string>

#include "io/picture_image.hpp"

namespace palpate::io {

/// Height in pixels of the strip that a caption takes at the bottom of an image; 0 for an empty caption.
int caption_height(const std::string& caption, int image_height);

/// Writes `caption` in dark grey into the caption strip of an image, in a smaller font if it is too wide.
/// Characters beyond ASCII become '?': VTK's built-in font has no others. Throws Error if the font cannot be
/// drawn.
void draw_caption(Image& image, const std::string& caption);

}  // namespace palpate::io

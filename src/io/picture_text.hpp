#pragma once

#include <string>

#include "io/picture_image.hpp"

namespace palpate::io {

/// The side of the given position on which a text is drawn.
enum class TextSide { right, left };

/// Width in pixels of a text. Characters beyond ASCII become '?': VTK's built-in font has no others. Throws
/// Error if the font cannot be drawn.
int text_width(const std::string& text, int font_size);

/// Writes a text in dark grey, centred on row `y`, on a side of column `x`; clipped at the image border.
/// Throws as text_width().
void draw_text(Image& image, const std::string& text, int font_size, int x, int y,
               TextSide side = TextSide::right);

}  // namespace palpate::io

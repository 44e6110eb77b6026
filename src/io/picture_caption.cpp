#include "io/picture_caption.hpp"

#include <algorithm>

#include "io/picture_text.hpp"

namespace palpate::io {

int caption_height(const std::string& caption, int image_height) {
  return caption.empty() ? 0 : std::max(10, image_height / 18);
}

void draw_caption(Image& image, const std::string& caption) {
  const int strip = caption_height(caption, image.height);
  if (strip == 0) return;
  const int left = strip / 2;
  const int room = image.width - 2 * left;
  int font_size = std::max(6, strip * 9 / 20);
  const int width = text_width(caption, font_size);
  if (width > room) font_size = std::max(4, font_size * room / width);
  draw_text(image, caption, font_size, left, image.height - strip + strip / 2);
}

}  // namespace palpate::io

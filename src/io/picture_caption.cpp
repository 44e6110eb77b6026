#include "io/picture_caption.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vtkFreeTypeTools.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>

#include <palpate/error.hpp>

namespace palpate::io {
namespace {

constexpr std::uint8_t ink = 62;  // dark grey

/// What VTK's built-in font can draw: ASCII. A UTF-8 character beyond it becomes one '?', a control character
/// a space.
std::string printable(const std::string& text) {
  std::string clean;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues_character = (byte & 0xC0U) == 0x80U;
    if (continues_character) continue;
    clean += byte >= 0x80U ? '?' : byte < 0x20U || byte == 0x7FU ? ' ' : c;
  }
  return clean;
}

struct TextImage {
  vtkNew<vtkImageData> pixels;  ///< RGBA, rows from the bottom
  std::array<int, 2> size{};    ///< the part of it that the text covers

  void draw(const std::string& text, int font_size) {
    vtkNew<vtkTextProperty> property;
    property->SetFontFamilyToArial();
    property->SetFontSize(font_size);
    property->SetColor(1.0, 1.0, 1.0);
    constexpr int dots_per_inch = 72;  // font sizes are then pixels
    if (!vtkFreeTypeTools::GetInstance()->RenderString(property, vtkStdString(text), dots_per_inch, pixels,
                                                       size.data())) {
      throw Error("picture", "caption", "text that VTK's FreeType cannot draw", "printable text");
    }
  }
  /// Coverage of the pixel in column x and row y from the top of the text, in [0, 1].
  [[nodiscard]] double coverage(int x, int y) {
    const int* extent = pixels->GetExtent();
    const int column = extent[0] + x;
    const int row = extent[2] + size[1] - 1 - y;
    if (column > extent[1] || row > extent[3]) return 0.0;
    return static_cast<const std::uint8_t*>(pixels->GetScalarPointer(column, row, 0))[3] / 255.0;
  }
};

}  // namespace

int caption_height(const std::string& caption, int image_height) {
  return caption.empty() ? 0 : std::max(10, image_height / 18);
}

void draw_caption(Image& image, const std::string& caption) {
  const int strip = caption_height(caption, image.height);
  if (strip == 0) return;
  const std::string text = printable(caption);
  const int left = strip / 2;
  const int room = image.width - 2 * left;
  int font_size = std::max(6, strip * 9 / 20);
  TextImage drawn;
  drawn.draw(text, font_size);
  if (drawn.size[0] > room) {
    font_size = std::max(4, font_size * room / drawn.size[0]);
    drawn.draw(text, font_size);
  }
  const int top = image.height - strip + (strip - drawn.size[1]) / 2;
  for (int y = 0; y < drawn.size[1]; ++y) {
    for (int x = 0; x < std::min(drawn.size[0], room); ++x) {
      if (top + y < 0 || top + y >= image.height) continue;
      const double coverage = drawn.coverage(x, y);
      std::uint8_t* pixel = image.pixel(left + x, top + y);
      for (int channel = 0; channel < 3; ++channel) {
        pixel[channel] =
            static_cast<std::uint8_t>(std::lround(pixel[channel] * (1.0 - coverage) + ink * coverage));
      }
    }
  }
}

}  // namespace palpate::io

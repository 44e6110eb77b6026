#include "io/picture_text.hpp"

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

/// Converts to ASCII, which is all that VTK's built-in font can draw. A UTF-8 character beyond it becomes one
/// '?', a control character a space.
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

int text_width(const std::string& text, int font_size) {
  TextImage drawn;
  drawn.draw(printable(text), font_size);
  return drawn.size[0];
}

void draw_text(Image& image, const std::string& text, int font_size, int x, int y, TextSide side) {
  TextImage drawn;
  drawn.draw(printable(text), font_size);
  const int left = side == TextSide::right ? x : x - drawn.size[0];
  const int top = y - drawn.size[1] / 2;
  for (int row = 0; row < drawn.size[1]; ++row) {
    for (int column = 0; column < drawn.size[0]; ++column) {
      if (top + row < 0 || top + row >= image.height || left + column < 0 || left + column >= image.width)
        continue;
      const double coverage = drawn.coverage(column, row);
      std::uint8_t* pixel = image.pixel(left + column, top + row);
      for (int channel = 0; channel < 3; ++channel) {
        pixel[channel] =
            static_cast<std::uint8_t>(std::lround(pixel[channel] * (1.0 - coverage) + ink * coverage));
      }
    }
  }
}

}  // namespace palpate::io

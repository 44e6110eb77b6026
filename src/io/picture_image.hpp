#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace palpate::io {

/// An 8-bit sRGB image, rows from top to bottom.
struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> bytes;  ///< (height x width x 3)

  Image() = default;
  Image(int columns, int rows)
      : width(columns),
        height(rows),
        bytes(3 * static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {}

  /// First of the three bytes of the pixel in column x, row y (from the top).
  [[nodiscard]] std::uint8_t* pixel(int x, int y) { return bytes.data() + offset(x, y); }
  [[nodiscard]] const std::uint8_t* pixel(int x, int y) const { return bytes.data() + offset(x, y); }

 private:
  [[nodiscard]] std::size_t offset(int x, int y) const {
    return 3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

/// Writes an image as PNG, whole or not at all (AtomicFile); the same image gives the same bytes. Throws
/// Error naming the path if it cannot be written.
void write_png(const std::filesystem::path& path, const Image& image);

}  // namespace palpate::io

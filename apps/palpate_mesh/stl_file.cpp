#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/text_scanner.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

constexpr std::size_t header_bytes = 84;
constexpr std::size_t triangle_bytes = 50;

/// Reads a little-endian number.
template <class Number>
Number number_at(std::string_view bytes, std::size_t place) {
  std::array<char, sizeof(Number)> own{};
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(place), own.size(), own.begin());
  if (std::endian::native == std::endian::big) std::ranges::reverse(own);
  return std::bit_cast<Number>(own);
}

void add_triangle(const std::array<Vec3, 3>& corners, PolygonFile& file) {
  const auto first = static_cast<Index>(file.points.size());
  file.points.insert(file.points.end(), corners.begin(), corners.end());
  file.polygons.push_back({first, first + 1, first + 2});
}

PolygonFile read_binary(const std::string& source, std::string_view bytes) {
  PolygonFile file;
  for (std::size_t begin = header_bytes; begin < bytes.size(); begin += triangle_bytes) {
    std::array<Vec3, 3> corners;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto coordinate = [&](std::size_t axis) {
        return static_cast<double>(number_at<float>(bytes, begin + 12 + 12 * corner + 4 * axis));
      };
      corners[corner] = {coordinate(0), coordinate(1), coordinate(2)};
      if (!is_finite(corners[corner])) {
        throw Error(source, fmt::format("triangle {}", file.polygons.size()),
                    "a coordinate that is not finite", "finite numbers");
      }
    }
    add_triangle(corners, file);
  }
  return file;
}

/// Reads a keyword; upper and lower case are the same.
void keyword(io::TextScanner& text, std::string_view expected) {
  const auto same = [](char a, char b) { return std::tolower(static_cast<unsigned char>(a)) == b; };
  if (!std::ranges::equal(text.word(expected.data()), expected, same)) text.fail(std::string(expected));
}

bool next_is(io::TextScanner& text, std::string_view word) {
  return std::ranges::equal(text.peek(), word, {},
                            [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
}

/// "endsolid", or "end solid" as some programs write it.
void end_of(io::TextScanner& text, const std::string& what) {
  if (!next_is(text, "end")) return keyword(text, "end" + what);
  keyword(text, "end");
  keyword(text, what);
}

PolygonFile read_text(const std::string& source, std::string_view bytes) {
  io::TextScanner text(source, bytes);
  PolygonFile file;
  while (!text.at_end()) {
    keyword(text, "solid");
    text.skip_line();
    while (next_is(text, "facet")) {
      keyword(text, "facet");
      text.skip_line();  // its normal, which some programs write as nan
      keyword(text, "outer");
      keyword(text, "loop");
      std::array<Vec3, 3> corners;
      for (Vec3& corner : corners) {
        keyword(text, "vertex");
        corner = text.point();
      }
      end_of(text, "loop");
      end_of(text, "facet");
      add_triangle(corners, file);
    }
    end_of(text, "solid");
    text.skip_line();
  }
  return file;
}

}  // namespace

PolygonFile read_stl(const std::string& source, std::string_view bytes) {
  // Binary files may begin with "solid" too, so the kind is decided by the length of the file.
  if (bytes.size() >= header_bytes) {
    const std::size_t expected = header_bytes + triangle_bytes * number_at<std::uint32_t>(bytes, 80);
    if (bytes.size() == expected) return read_binary(source, bytes);
    if (!bytes.starts_with("solid") && !bytes.starts_with("SOLID")) {
      throw Error(
          source, "", fmt::format("{} bytes", bytes.size()),
          fmt::format("{}, as many as a binary STL file says, or the word \"solid\" of a text", expected));
    }
  }
  return read_text(source, bytes);
}

}  // namespace palpate::app

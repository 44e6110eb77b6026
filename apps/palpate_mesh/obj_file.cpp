#include <charconv>
#include <cstdint>
#include <fmt/format.h>
#include <limits>

#include "io/text_scanner.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

/// The point of a corner "7", "7/1", "7//3" or "-1/2/3": counted from 1, or back from the last point so far.
Index point_of(io::TextScanner& text, std::int64_t points) {
  const std::string_view corner = text.word("a corner");
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(corner.data(), corner.data() + corner.size(), number);
  if (error != std::errc{} || (end != corner.data() + corner.size() && *end != '/'))
    text.fail("the number of a point, or numbers with / between them");
  const std::int64_t index = number < 0 ? points + number : number - 1;
  if (number == 0 || index < 0 || index >= points)
    text.fail(fmt::format("one of the {} points before it, counted from 1", points));
  return static_cast<Index>(index);
}

}  // namespace

PolygonFile read_obj(const std::string& source, std::string_view bytes) {
  io::TextScanner text(source, bytes, '#');
  PolygonFile file;
  while (!text.at_end()) {
    const std::string_view word = text.word("a line");
    if (word == "v") {
      file.points.push_back(text.point());
    } else if (word == "f") {
      std::vector<Index>& polygon = file.polygons.emplace_back();
      while (!text.at_line_end())
        polygon.push_back(point_of(text, static_cast<std::int64_t>(file.points.size())));
    }
    text.skip_line();
  }
  return file;
}

}  // namespace palpate::app

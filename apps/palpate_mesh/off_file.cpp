#include <fmt/format.h>
#include <string>

#include "io/text_scanner.hpp"
#include "surface_file.hpp"

namespace palpate::app {
namespace {

/// The keyword before the counts: "OFF", with letters for further properties of a point, or nothing.
struct OffHead {
  bool more_at_points = false;  ///< after x, y and z come normals, colours or texture coordinates
};

OffHead read_head(io::TextScanner& text) {
  constexpr std::string_view name = "OFF";
  const std::string_view word = text.peek();
  const auto found = word.find(name);
  if (found == std::string_view::npos) return {};  // the keyword is optional
  const std::string_view letters = word.substr(0, found);
  const std::size_t begin = text.position();
  text.word("OFF");
  if (letters.find_first_not_of("STCN") != std::string_view::npos)
    text.fail("OFF, COFF, NOFF or STOFF, with points of three coordinates");
  text.set_position(begin + found + name.size());  // some programs write the counts right behind it
  if (!text.at_line_end() && text.peek() == "BINARY") {
    text.word("");
    text.fail("an OFF file in text");
  }
  return {!letters.empty()};
}

io::TextScanner& in_line(io::TextScanner& text) {
  if (text.at_line_end()) text.fail("the end of the line", "three coordinates of a point in it");
  return text;
}

/// x, y and z of a point, in one line, so that a missing number does not shift all others.
Vec3 read_point(io::TextScanner& text) {
  const Vec3 point{text.number("the x of a point"), in_line(text).number("the y of a point"),
                   in_line(text).number("the z of a point")};
  return point;
}

}  // namespace

PolygonFile read_off(const std::string& source, std::string_view bytes) {
  io::TextScanner text(source, bytes, '#');
  const OffHead head = read_head(text);
  PolygonFile file;
  const Index points = text.count("the number of points", 6);
  const Index polygons = text.count("the number of polygons", 2);
  if (!text.at_line_end()) text.integer("the number of edges");
  file.points.reserve(static_cast<std::size_t>(points));
  for (Index i = 0; i < points; ++i) {
    file.points.push_back(read_point(text));
    if (head.more_at_points) text.skip_line();
  }
  file.polygons.reserve(static_cast<std::size_t>(polygons));
  for (Index i = 0; i < polygons; ++i) {
    const Index corners = text.count("the number of corners of a polygon", 2);
    std::vector<Index>& polygon = file.polygons.emplace_back();
    for (Index corner = 0; corner < corners; ++corner) polygon.push_back(text.point_index(0, points));
    text.skip_line();  // its colour
  }
  if (!text.at_end()) {
    text.word("");
    text.fail(fmt::format("the end of the file after {} polygons", polygons));
  }
  return file;
}

}  // namespace palpate::app

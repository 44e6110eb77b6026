#include <array>
#include <fmt/format.h>
#include <span>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/text_scanner.hpp"
#include "io/volume_cells.hpp"

namespace palpate::io {
namespace {

constexpr std::int64_t most_attributes = 1000;  // far above real files; a larger count is damage

std::int64_t optional_integer(TextScanner& scanner, const char* what, std::int64_t low, std::int64_t high,
                              std::int64_t absent) {
  return scanner.at_line_end() ? absent : scanner.integer(what, low, high);
}

void end_record(TextScanner& scanner, const char* expected) {
  if (scanner.at_line_end()) return;
  scanner.word(expected);
  scanner.fail(expected);
}

void skip_numbers(TextScanner& scanner, std::int64_t count, const char* what) {
  for (std::int64_t i = 0; i < count; ++i) scanner.number(what);
}

/// The points of a .node file.
struct Nodes {
  std::vector<Vec3> points;
  Index first = 0;  ///< the number of the first point: 0 or 1
};

Nodes read_nodes(TextScanner& scanner) {
  // A record has at least a number, three coordinates, and a byte between any two.
  const Index count = scanner.count("the number of points", 8);
  optional_integer(scanner, "the dimension (only 3 is read)", 3, 3, 3);
  const auto attributes = optional_integer(scanner, "the number of attributes", 0, most_attributes, 0);
  const auto markers = optional_integer(scanner, "the number of boundary markers", 0, 1, 0);
  end_record(scanner, "the end of the header line");
  Nodes nodes;
  nodes.points.reserve(static_cast<std::size_t>(count));
  for (Index i = 0; i < count; ++i) {
    if (i == 0) nodes.first = static_cast<Index>(scanner.integer("the number of the first point", 0, 1));
    if (i > 0 && scanner.integer("a point number") != nodes.first + i) {
      scanner.fail(fmt::format("point number {}", nodes.first + i));
    }
    nodes.points.push_back(scanner.point());
    skip_numbers(scanner, attributes, "an attribute of a point");
    skip_numbers(scanner, markers, "the boundary marker of a point");
    end_record(scanner, "the end of the point's line");
  }
  if (!scanner.at_end()) end_record(scanner, "the end of the file behind the last point");
  return nodes;
}

void read_elements(TextScanner& scanner, Index first_point, MeshFile& file) {
  const Index count = scanner.count("the number of tets", 10);
  const auto corners = optional_integer(scanner, "the number of points of a tet", 4, 10, 4);
  if (corners != 4 && corners != 10) scanner.fail("4 or 10 points a tet");
  const auto attributes = optional_integer(scanner, "the number of region attributes", 0, most_attributes, 0);
  end_record(scanner, "the end of the header line");
  std::int64_t first_tet = 0;
  for (Index i = 0; i < count; ++i) {
    if (i == 0) first_tet = scanner.integer("the number of the first tet", 0, 1);
    if (i > 0 && scanner.integer("a tet number") != first_tet + i) {
      scanner.fail(fmt::format("tet number {}", first_tet + i));
    }
    std::array<Index, 10> points{};
    for (std::size_t corner = 0; corner < static_cast<std::size_t>(corners); ++corner)
      points[corner] = scanner.point_index(first_point, static_cast<Index>(file.mesh.points.size()));
    skip_numbers(scanner, attributes, "a region attribute of a tet");
    end_record(scanner, "the end of the tet's line");
    add_volume_cell(file, corners == 4 ? "tetrahedron" : "tetrahedron10", std::span(points).first<4>());
  }
  if (!scanner.at_end()) end_record(scanner, "the end of the file behind the last tet");
}

/// The .node and the .ele file, from the path of either; both extensions have the same case.
std::pair<std::filesystem::path, std::filesystem::path> pair_of(const std::filesystem::path& path) {
  const char letter = path.extension().string().at(1);
  const bool upper = letter == 'N' || letter == 'E';
  const bool is_node = letter == 'N' || letter == 'n';
  std::filesystem::path other = path;
  other.replace_extension(is_node ? (upper ? ".ELE" : ".ele") : (upper ? ".NODE" : ".node"));
  return is_node ? std::pair{path, other} : std::pair{other, path};
}

}  // namespace

MeshFile read_tetgen(const std::filesystem::path& path) {
  const auto [node_path, ele_path] = pair_of(path);
  const std::string node_text = read_file(node_path, "the TetGen points of " + path.string());
  const std::string ele_text = read_file(ele_path, "the TetGen tets of " + path.string());
  require_line_end(node_path.string(), node_text);
  require_line_end(ele_path.string(), ele_text);

  MeshFile file;
  file.format = "TetGen";
  TextScanner node_scanner(node_path.string(), node_text, '#');
  Nodes nodes = read_nodes(node_scanner);
  file.mesh.points = std::move(nodes.points);
  if (file.mesh.points.empty()) require_tets(file, node_path.string());
  TextScanner ele_scanner(ele_path.string(), ele_text, '#');
  read_elements(ele_scanner, nodes.first, file);
  require_tets(file, ele_path.string());
  return file;
}

}  // namespace palpate::io

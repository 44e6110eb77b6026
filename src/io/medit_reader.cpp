#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>
#include <span>
#include <string>
#include <string_view>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/text_scanner.hpp"
#include "io/volume_cells.hpp"

namespace palpate::io {
namespace {

struct CellSection {
  std::string_view keyword;
  std::string_view kind;
  int corners;
};

constexpr std::array<CellSection, 12> cell_sections{{{"Edges", "line", 2},
                                                     {"EdgesP2", "line3", 3},
                                                     {"Triangles", "triangle", 3},
                                                     {"TrianglesP2", "triangle6", 6},
                                                     {"Quadrilaterals", "quad", 4},
                                                     {"Tetrahedra", "tetrahedron", 4},
                                                     {"TetrahedraP2", "tetrahedron10", 10},
                                                     {"Hexahedra", "hexahedron", 8},
                                                     {"Hexaedra", "hexahedron", 8},
                                                     {"Prisms", "wedge", 6},
                                                     {"Pentahedra", "wedge", 6},
                                                     {"Pyramids", "pyramid", 5}}};

/// The least size of a record of n numbers: one digit and a separator each.
constexpr std::size_t least_bytes(int numbers) {
  return 2 * static_cast<std::size_t>(numbers);
}

class MeditReader {
 public:
  explicit MeditReader(TextScanner& scanner) : scanner_(scanner) {}

  MeshFile read() {
    scanner_.keyword("MeshVersionFormatted");
    scanner_.integer("the version of the Medit format", 1, 4);
    while (true) {
      const std::string_view keyword = scanner_.word("the keyword End (the file may be cut off)");
      if (keyword == "End") break;
      read_section(keyword);
    }
    file_.format = "Medit ASCII";
    require_tets(file_, scanner_.source());
    return std::move(file_);
  }

 private:
  void read_section(std::string_view keyword) {
    if (std::isalpha(static_cast<unsigned char>(keyword[0])) == 0) scanner_.fail("a keyword");
    if (keyword == "Dimension") {
      read_dimension();
    } else if (keyword == "Vertices") {
      read_points();
    } else {
      read_cells(keyword);
    }
  }

  void read_dimension() {
    if (scanner_.integer("the dimension") != 3) scanner_.fail("Dimension 3");
    has_dimension_ = true;
  }

  void read_points() {
    if (!has_dimension_) scanner_.fail("Dimension 3 before Vertices");
    if (has_points_) scanner_.fail("only one section Vertices");
    has_points_ = true;
    const Index count = scanner_.count("the number of vertices", least_bytes(4));
    file_.mesh.points.reserve(static_cast<std::size_t>(count));
    for (Index i = 0; i < count; ++i) {
      file_.mesh.points.push_back(scanner_.point());
      scanner_.number("the reference of a vertex");
    }
  }

  /// Reads cells with a volume and counts others. Skips the numbers of all other sections (normals, corners,
  /// those of later versions).
  void read_cells(std::string_view keyword) {
    const auto section = std::ranges::find(cell_sections, keyword, &CellSection::keyword);
    if (section == cell_sections.end()) return skip_numbers();
    const std::size_t wanted = volume_corners(section->kind);
    if (wanted > 0 && !has_points_) scanner_.fail(fmt::format("Vertices before {}", keyword));
    const Index count = scanner_.count("the number of cells", least_bytes(section->corners + 1));
    if (wanted == 0) return skip_cells(*section, count);
    const auto n_points = static_cast<Index>(file_.mesh.points.size());
    std::array<Index, 8> corners{};
    for (Index i = 0; i < count; ++i) {
      for (std::size_t corner = 0; corner < static_cast<std::size_t>(section->corners); ++corner) {
        const Index point = scanner_.point_index(1, n_points);
        if (corner < wanted) corners[corner] = point;
      }
      scanner_.number("the reference of a cell");
      add_volume_cell(file_, section->kind, std::span(corners).first(wanted));
    }
  }

  void skip_cells(const CellSection& section, Index count) {
    for (Index i = 0; i < count; ++i) {
      for (int number = 0; number <= section.corners; ++number)
        scanner_.number("a corner or reference of a cell");
    }
    count_dropped(file_, section.kind, count);
  }

  void skip_numbers() {
    while (!scanner_.at_end() && std::isalpha(static_cast<unsigned char>(scanner_.peek()[0])) == 0)
      scanner_.word("");
  }

  TextScanner& scanner_;
  MeshFile file_;
  bool has_dimension_ = false;
  bool has_points_ = false;
};

}  // namespace

MeshFile read_medit(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, "a Medit mesh file");
  TextScanner scanner(path.string(), bytes, '#');
  return MeditReader(scanner).read();
}

}  // namespace palpate::io

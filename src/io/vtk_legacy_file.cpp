#include "io/vtk_legacy_file.hpp"

#include <cmath>
#include <fmt/format.h>
#include <string_view>
#include <utility>

#include <palpate/error.hpp>

#include "io/text_scanner.hpp"
#include "io/vtk_legacy_numbers.hpp"

namespace palpate::io {
namespace {

class LegacyFileReader {
 public:
  explicit LegacyFileReader(TextScanner& scanner) : scanner_(scanner), numbers_(scanner) {}

  VtkLegacyFile read() {
    read_head();
    while (!scanner_.at_end() && read_section()) continue;
    if (!has_points_) scanner_.fail_end("the section POINTS");
    if (file_.dataset == Dataset::unstructured_grid) {
      if (!has_cells_) scanner_.fail_end("the section CELLS");
      if (!has_types_) scanner_.fail_end("the section CELL_TYPES");
    }
    if (!file_.binary) require_line_end(scanner_.source(), scanner_.text());
    file_.data_begin = scanner_.position();
    return std::move(file_);
  }

 private:
  using Dataset = VtkLegacyFile::Dataset;

  void read_head() {
    for (const std::string_view word : {"#", "vtk", "DataFile", "Version"}) scanner_.keyword(word);
    const double version = scanner_.number("the version of the VTK format");
    if (version < 1.0 || version >= 6.0) scanner_.fail("a version from 1.0 to 5.1");
    has_offsets_ = version >= 5.0;
    scanner_.skip_line();
    scanner_.skip_line();  // the title, any text
    const std::string encoding = upper_case(scanner_.word("ASCII or BINARY"));
    if (encoding != "ASCII" && encoding != "BINARY") scanner_.fail("ASCII or BINARY");
    file_.binary = encoding == "BINARY";
    numbers_.set_binary(file_.binary);
  }

  /// Reads a section; false at the first section after the mesh.
  bool read_section() {
    const std::string name = upper_case(scanner_.peek());
    if (name == "POINT_DATA" || name == "CELL_DATA") return false;
    if (name == "METADATA") {
      numbers_.skip_metadata();
      return true;
    }
    scanner_.word("");
    if (name == "DATASET") {
      claim_once(has_dataset_);
      read_dataset();
    } else if (name == "POINTS") {
      claim_once(has_points_);
      read_points();
    } else if (name == "CELLS" || name == "POLYGONS") {
      claim_once(has_cells_);
      read_cells(file_.cells);
    } else if (name == "TRIANGLE_STRIPS") {
      claim_once(has_strips_);
      read_cells(file_.strips);
    } else if (name == "VERTICES" || name == "LINES") {
      VtkCells unused;
      read_cells(unused);
    } else if (name == "CELL_TYPES") {
      claim_once(has_types_);
      const Index count = scanner_.count("the number of cell types", numbers_.least_bytes(4));
      file_.cells.types = read_integers(count, *scalar_type("int"));
    } else if (name == "FIELD") {
      skip_field();
    } else {
      scanner_.fail("a section such as POINTS or CELLS");
    }
    return true;
  }

  void read_dataset() {
    const std::string kind = upper_case(scanner_.word("a kind of dataset"));
    if (kind == "POLYDATA") {
      file_.dataset = Dataset::poly_data;
    } else if (kind != "UNSTRUCTURED_GRID") {
      scanner_.fail("UNSTRUCTURED_GRID or POLYDATA");
    }
  }

  void claim_once(bool& seen) {
    if (seen) scanner_.fail("each section once");
    seen = true;
  }

  void read_points() {
    const Index count = scanner_.count("the number of points", 3 * numbers_.least_bytes(1));
    const ScalarType& type = numbers_.read_type();
    file_.points.reserve(static_cast<std::size_t>(count));
    if (!file_.binary) {
      for (Index i = 0; i < count; ++i) file_.points.push_back(scanner_.point());
      return;
    }
    const std::vector<double> values =
        numbers_.reals(3 * static_cast<std::size_t>(count), type, "a coordinate");
    const std::size_t begin = scanner_.position() - values.size() * type.bytes;
    for (std::size_t i = 0; i + 2 < values.size(); i += 3) {
      const Vec3 point{values[i], values[i + 1], values[i + 2]};
      if (!std::isfinite(point.x + point.y + point.z)) check_finite(point, begin + i * type.bytes);
      file_.points.push_back(point);
    }
  }

  void check_finite(const Vec3& point, std::size_t byte) {
    if (std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z)) return;
    throw Error(scanner_.source(), fmt::format("byte {}", byte),
                fmt::format("the point ({}, {}, {})", point.x, point.y, point.z), "finite coordinates");
  }

  void read_cells(VtkCells& cells) {
    has_offsets_ ? read_cells_with_offsets(cells) : read_cells_with_counts(cells);
  }

  /// Reads cells of versions before 5: for each cell its number of corners, then the corners.
  void read_cells_with_counts(VtkCells& cells) {
    const Index count = scanner_.count("the number of cells", numbers_.least_bytes(4));
    const Index size = scanner_.count("the size of the cell list", numbers_.least_bytes(4));
    const std::vector<std::int64_t> list = read_integers(size, *scalar_type("int"));
    cells.ends.reserve(static_cast<std::size_t>(count));
    cells.connectivity.reserve(list.size());
    std::size_t next = 0;
    for (Index cell = 0; cell < count; ++cell) {
      const std::int64_t corners = next < list.size() ? list[next++] : -1;
      if (corners < 0 || static_cast<std::uint64_t>(corners) > list.size() - next) {
        throw Error(scanner_.source(), fmt::format("cell {}", cell), "a cell beyond the end of the cell list",
                    fmt::format("cells that fill the {} numbers that the section announces", size));
      }
      const auto begin = list.begin() + static_cast<std::ptrdiff_t>(next);
      cells.connectivity.insert(cells.connectivity.end(), begin, begin + corners);
      cells.ends.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
      next += static_cast<std::size_t>(corners);
    }
    if (next != list.size()) {
      throw Error(scanner_.source(), "cells",
                  fmt::format("{} numbers behind the last cell", list.size() - next), "none");
    }
  }

  /// Reads cells of version 5 on: the first index of each cell, and the end of the last; then all corners.
  void read_cells_with_offsets(VtkCells& cells) {
    const Index offsets = scanner_.count("the number of cell offsets", numbers_.least_bytes(4));
    const Index size = scanner_.count("the size of the connectivity", numbers_.least_bytes(4));
    scanner_.keyword("OFFSETS");
    cells.ends = read_integers(offsets, numbers_.read_type());
    if (!cells.ends.empty()) {
      if (cells.ends.front() != 0) {
        throw Error(scanner_.source(), "OFFSETS", fmt::format("{} first", cells.ends.front()), "0 first");
      }
      cells.ends.erase(cells.ends.begin());
    }
    scanner_.keyword("CONNECTIVITY");
    cells.connectivity = read_integers(size, numbers_.read_type());
  }

  std::vector<std::int64_t> read_integers(Index count, const ScalarType& type) {
    return numbers_.integers(static_cast<std::size_t>(count), type, "a number of a cell");
  }

  /// Skips a field before the mesh, in which VTK writes the time step.
  void skip_field() {
    scanner_.word("the name of a field");
    const Index arrays = scanner_.count("the number of arrays", 8);
    for (Index array = 0; array < arrays; ++array) {
      scanner_.word("the name of an array");
      const auto components = static_cast<std::size_t>(scanner_.count("the number of components", 1));
      const auto tuples = static_cast<std::size_t>(scanner_.count("the number of tuples", 1));
      const ScalarType& type = numbers_.read_type();
      numbers_.skip(components * tuples, type);
      numbers_.skip_metadata();
    }
  }

  TextScanner& scanner_;
  LegacyNumbers numbers_;
  VtkLegacyFile file_;
  bool has_offsets_ = false;
  bool has_dataset_ = false;
  bool has_points_ = false;
  bool has_cells_ = false;
  bool has_strips_ = false;
  bool has_types_ = false;
};

}  // namespace

VtkLegacyFile read_vtk_legacy_file(const std::string& source, std::string_view bytes) {
  TextScanner scanner(source, bytes);
  return LegacyFileReader(scanner).read();
}

}  // namespace palpate::io

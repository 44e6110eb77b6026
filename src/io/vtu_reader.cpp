#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <vector>

#include <palpate/error.hpp>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/vtk_cells.hpp"
#include "io/vtu_arrays.hpp"
#include "io/vtu_structure.hpp"

namespace palpate::io {
namespace {

class VtuReader {
 public:
  VtuReader(const std::string& source, std::string_view text)
      : source_(source), structure_(read_vtu_structure(source, text)), arrays_(source, text, structure_) {}

  MeshFile read() {
    file_.format = "VTK XML";
    for (std::size_t i = 0; i < structure_.pieces.size(); ++i) append(structure_.pieces[i], i);
    require_tets(file_, source_);
    return std::move(file_);
  }

  std::vector<double> read_cell_data(const CellDataKey& key) {
    std::vector<double> data;
    for (std::size_t i = 0; i < structure_.pieces.size(); ++i)
      append_data(structure_.pieces[i], i, key, data);
    require_tets(file_, source_);
    return data;
  }

 private:
  /// Returns the number of tets of each cell.
  std::vector<Index> append(const VtuPiece& piece, std::size_t number) {
    const auto first_point = static_cast<std::int64_t>(file_.mesh.points.size());
    constexpr std::int64_t most = std::numeric_limits<Index>::max();
    if (piece.points > most - first_point || piece.cells.count > most - n_cells_) {
      throw Error(source_, fmt::format("piece {}", number),
                  fmt::format("{} points and {} cells", piece.points, piece.cells.count),
                  fmt::format("at most {} of each in all pieces", most));
    }
    append_points(piece, number);
    return append_cells(piece, number, static_cast<Index>(first_point));
  }

  [[nodiscard]] const VtuArray& require(const std::optional<VtuArray>& array, const char* name,
                                        std::size_t number) const {
    if (!array)
      throw Error(source_, fmt::format("piece {}", number), fmt::format("no array of {}", name), "one");
    return *array;
  }

  void append_points(const VtuPiece& piece, std::size_t number) {
    if (piece.points == 0) return;
    const VtuArray& array = require(piece.coordinates, "Points", number);
    if (array.components != 3) {
      throw Error(source_, "array Points", fmt::format("{} components", array.components), "3");
    }
    const std::vector<double> values = arrays_.reals(array, 3 * piece.points);
    for (std::size_t i = 0; i < values.size(); i += 3) {
      file_.mesh.points.push_back({values[i], values[i + 1], values[i + 2]});
    }
  }

  [[nodiscard]] VtkCells cells_of(const VtuPiece& piece, std::size_t number) const {
    VtkCells cells;
    if (piece.cells.count == 0) return cells;
    cells.types = arrays_.integers(require(piece.cells.types, "types", number), piece.cells.count);
    cells.ends = arrays_.integers(require(piece.cells.offsets, "offsets", number), piece.cells.count);
    if (cells.ends.back() < 0) {
      throw Error(source_, "array offsets", fmt::format("{} last", cells.ends.back()), "0 or more");
    }
    cells.connectivity =
        arrays_.integers(require(piece.cells.connectivity, "connectivity", number), cells.ends.back());
    return cells;
  }

  std::vector<Index> append_cells(const VtuPiece& piece, std::size_t number, Index first_point) {
    const std::int64_t first_cell = n_cells_;
    n_cells_ += piece.cells.count;
    return append_vtk_cells(cells_of(piece, number), first_point, static_cast<Index>(piece.points),
                            first_cell, source_, file_);
  }

  /// The numbers of each tet that a cell becomes.
  void append_data(const VtuPiece& piece, std::size_t number, const CellDataKey& key,
                   std::vector<double>& data) {
    const std::vector<Index> tets_of_cells = append(piece, number);
    if (piece.cells.count == 0) return;
    const auto array = std::ranges::find(piece.cell_data, key.name, &VtuArray::name);
    if (array == piece.cell_data.end()) {
      throw Error(source_, fmt::format("piece {}", number), "no cell data of the name '" + key.name + "'",
                  "some");
    }
    const auto components = static_cast<std::int64_t>(key.components);
    if (array->components != components) {
      throw Error(source_, "cell data " + key.name, fmt::format("{} components", array->components),
                  key.expected());
    }
    append_cell_data(arrays_.reals(*array, components * piece.cells.count), tets_of_cells, data);
  }

  const std::string& source_;
  VtuStructure structure_;
  VtuArrays arrays_;
  MeshFile file_;
  std::int64_t n_cells_ = 0;
};

}  // namespace

MeshFile read_vtu(const std::filesystem::path& path) {
  return read_vtu_text(path.string(), read_file(path, "a VTK XML unstructured grid"));
}

MeshFile read_vtu_text(const std::string& source, std::string_view text) {
  return VtuReader(source, text).read();
}

std::vector<double> read_vtu_data(const std::filesystem::path& path, const CellDataKey& key) {
  return read_vtu_data_text(path.string(), read_file(path, "a VTK XML unstructured grid"), key);
}

std::vector<double> read_vtu_data_text(const std::string& source, std::string_view text,
                                       const CellDataKey& key) {
  return VtuReader(source, text).read_cell_data(key);
}

}  // namespace palpate::io

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/io/cell_vectors.hpp>

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

  std::vector<Vec3> read_cell_vectors(const std::string& name) {
    std::vector<Vec3> vectors;
    for (std::size_t i = 0; i < structure_.pieces.size(); ++i)
      append_vectors(structure_.pieces[i], i, name, vectors);
    require_tets(file_, source_);
    return vectors;
  }

 private:
  void append(const VtuPiece& piece, std::size_t number) {
    const auto first_point = static_cast<std::int64_t>(file_.mesh.points.size());
    constexpr std::int64_t most = std::numeric_limits<Index>::max();
    if (piece.points > most - first_point || piece.cells.count > most - n_cells_) {
      throw Error(source_, fmt::format("piece {}", number),
                  fmt::format("{} points and {} cells", piece.points, piece.cells.count),
                  fmt::format("at most {} of each in all pieces", most));
    }
    append_points(piece, number);
    append_cells(piece, number, static_cast<Index>(first_point));
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

  void append_cells(const VtuPiece& piece, std::size_t number, Index first_point) {
    const VtkCells cells = cells_of(piece, number);
    append_vtk_cells(cells, first_point, static_cast<Index>(piece.points), n_cells_, source_, file_);
    n_cells_ += piece.cells.count;
  }

  /// The vector of each tet that a cell becomes.
  void append_vectors(const VtuPiece& piece, std::size_t number, const std::string& name,
                      std::vector<Vec3>& vectors) {
    const auto first_point = static_cast<Index>(file_.mesh.points.size());
    append(piece, number);
    if (piece.cells.count == 0) return;
    const auto array = std::ranges::find(piece.cell_data, name, &VtuArray::name);
    if (array == piece.cell_data.end()) {
      throw Error(source_, fmt::format("piece {}", number), "no cell data of the name '" + name + "'",
                  "some");
    }
    if (array->components != 3) {
      throw Error(source_, "cell data " + name, fmt::format("{} components", array->components),
                  "3: a vector for each cell");
    }
    const std::vector<double> values = arrays_.reals(*array, 3 * piece.cells.count);
    const std::vector<Index> counts = tets_of_cells(cells_of(piece, number), piece, first_point);
    for (std::size_t cell = 0; cell < counts.size(); ++cell) {
      const Vec3 vector{values[3 * cell], values[3 * cell + 1], values[3 * cell + 2]};
      vectors.insert(vectors.end(), static_cast<std::size_t>(counts[cell]), vector);
    }
  }

  /// How many tets each cell becomes: one by one, since a cell's are its own alone. The cells are good.
  [[nodiscard]] std::vector<Index> tets_of_cells(const VtkCells& cells, const VtuPiece& piece,
                                                 Index first_point) const {
    std::vector<Index> counts;
    MeshFile alone;
    alone.mesh.points = file_.mesh.points;
    std::int64_t begin = 0;
    for (std::size_t cell = 0; cell < cells.ends.size(); ++cell) {
      const auto place = [&](std::int64_t i) { return cells.connectivity.begin() + i; };
      const VtkCells one{
          {place(begin), place(cells.ends[cell])}, {cells.ends[cell] - begin}, {cells.types[cell]}};
      const std::size_t before = alone.mesh.tets.size();
      append_vtk_cells(one, first_point, static_cast<Index>(piece.points), 0, source_, alone);
      counts.push_back(static_cast<Index>(alone.mesh.tets.size() - before));
      begin = cells.ends[cell];
    }
    return counts;
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

std::vector<Vec3> read_cell_vectors(const std::filesystem::path& path, const std::string& name) {
  if (!path.extension().string().ends_with("vtu") && !path.extension().string().ends_with("VTU")) {
    throw Error(path.string(), "cell data " + name, "the extension " + path.extension().string(),
                ".vtu: of other files vectors of cells are not read");
  }
  return VtuReader(path.string(), read_file(path, "a VTK XML unstructured grid")).read_cell_vectors(name);
}

}  // namespace palpate::io

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::io {

/// The cells of a VTK file as its arrays give them.
struct VtkCells {
  std::vector<std::int64_t> connectivity;  ///< point numbers of all cells, one cell after the other
  std::vector<std::int64_t> ends;          ///< (n_cells): where in connectivity each cell ends
  std::vector<std::int64_t> types;         ///< (n_cells): VTK's numbers
};

/// Appends tets, and the tets of other volume cells, to the mesh; counts all other cells. `first_point` is
/// added to point numbers. Returns the number of tets of each cell.
///
/// Throws Error naming the cell (0-based in the file: `first_cell` is the number of the first here) if
/// ends do not ascend to the length of the connectivity, a type is unknown, a number of corners does not fit
/// the type, or a point number is outside [0, n_points).
std::vector<Index> append_vtk_cells(const VtkCells& cells, Index first_point, Index n_points,
                                    std::int64_t first_cell, const std::string& source, MeshFile& file);

/// Which data of cells to read.
struct CellDataKey {
  std::string name;
  std::size_t components = 3;

  /// What a file should have, as text: "1: a number for each cell".
  [[nodiscard]] std::string expected() const;
};

/// Appends the numbers of each cell (n_cells x components) once for each tet that the cell became.
void append_cell_data(std::span<const double> values, std::span<const Index> tets_of_cells,
                      std::vector<double>& data);

}  // namespace palpate::io

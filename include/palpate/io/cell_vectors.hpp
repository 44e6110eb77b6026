#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::io {

/// Vectors of the cells of a mesh file, such as directions of fibres: one for each tet of read_mesh(), in the
/// same order. Where a cell is cut into several tets, each has the vector of the cell.
///
/// Throws Error as read_mesh(), and if the file has a different format, no such array, or not three finite
/// numbers for each cell with a volume. O(file size).
/// \param name  of cell data of three components: an array of a `.vtu` file; VECTORS, NORMALS or an array of
///              a FIELD of a `.vtk` file; $ElementData of a `.msh` file (its first time step)
std::vector<Vec3> read_cell_vectors(const std::filesystem::path& path, const std::string& name);

/// read_cell_vectors() for any number of components (labels of tissues have one): (n_tets x components)
/// numbers. Also reads SCALARS of a `.vtk` file. For a `.msh` file `components` must be 3, otherwise an
/// Error is thrown.
std::vector<double> read_cell_data(const std::filesystem::path& path, const std::string& name,
                                   std::size_t components);

}  // namespace palpate::io

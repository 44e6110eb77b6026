#include <cstdint>
#include <exception>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <vtkCellArray.h>
#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkDataArraySelection.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkUnsignedCharArray.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <palpate/error.hpp>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/text_scanner.hpp"
#include "io/vtk_errors.hpp"

namespace palpate::io {
namespace {

/// Our word for a VTK cell type, as the other formats use it; VTK's own for the rest.
std::string kind_of(int type) {
  switch (type) {
    case VTK_VERTEX:
      return "vertex";
    case VTK_LINE:
      return "line";
    case VTK_TRIANGLE:
      return "triangle";
    case VTK_QUAD:
      return "quad";
    case VTK_HEXAHEDRON:
      return "hexahedron";
    case VTK_WEDGE:
      return "wedge";
    case VTK_PYRAMID:
      return "pyramid";
    case VTK_QUADRATIC_EDGE:
      return "line3";
    case VTK_QUADRATIC_TRIANGLE:
      return "triangle6";
    case VTK_QUADRATIC_TETRA:
      return "tetrahedron10";
    default:
      return vtkCellTypes::GetClassNameFromTypeId(type);
  }
}

/// Corners that a cell of a type has, or 0 where the type leaves it open.
vtkIdType corners_of(int type) {
  switch (type) {
    case VTK_VERTEX:
      return 1;
    case VTK_LINE:
      return 2;
    case VTK_TRIANGLE:
    case VTK_QUADRATIC_EDGE:
      return 3;
    case VTK_QUAD:
    case VTK_TETRA:
      return 4;
    case VTK_PYRAMID:
      return 5;
    case VTK_WEDGE:
    case VTK_QUADRATIC_TRIANGLE:
      return 6;
    case VTK_HEXAHEDRON:
      return 8;
    case VTK_QUADRATIC_TETRA:
      return 10;
    default:
      return 0;
  }
}

void copy_points(vtkUnstructuredGrid& grid, const std::string& source, TetMesh& mesh) {
  const vtkIdType count = grid.GetNumberOfPoints();
  if (count > std::numeric_limits<Index>::max()) {
    throw Error(source, "", fmt::format("{} points", count), "at most 2147483647");
  }
  mesh.points.resize(static_cast<std::size_t>(count));
  for (vtkIdType i = 0; i < count; ++i) {
    Vec3& point = mesh.points[static_cast<std::size_t>(i)];
    grid.GetPoints()->GetPoint(i, &point.x);
  }
}

/// What GetCellAtId() takes on trust.
void require_valid_cells(vtkUnstructuredGrid& grid, const std::string& source) {
  vtkCellArray* cells = grid.GetCells();
  const vtkIdType count = cells == nullptr ? 0 : cells->GetNumberOfCells();
  vtkUnsignedCharArray* types = grid.GetCellTypesArray();
  const vtkIdType typed = types == nullptr ? 0 : types->GetNumberOfValues();
  if (count != typed) {
    throw Error(source, "", fmt::format("{} cells and {} cell types", count, typed), "as many of both");
  }
  if (count > std::numeric_limits<Index>::max()) {
    throw Error(source, "", fmt::format("{} cells", count), "at most 2147483647");
  }
  if (cells != nullptr && !cells->IsValid()) {
    throw Error(source, "", "offsets of cells that do not ascend or end beyond the connectivity",
                "offsets from 0 up to the number of corners");
  }
}

void copy_cells(vtkUnstructuredGrid& grid, const std::string& source, MeshFile& file) {
  const vtkIdType n_points = grid.GetNumberOfPoints();
  const vtkIdType n_cells = grid.GetCells() == nullptr ? 0 : grid.GetCells()->GetNumberOfCells();
  for (vtkIdType cell = 0; cell < n_cells; ++cell) {
    const int type = grid.GetCellTypesArray()->GetValue(cell);
    const vtkIdType* corners = nullptr;
    vtkIdType n_corners = 0;
    grid.GetCells()->GetCellAtId(cell, n_corners, corners);
    if (corners_of(type) != 0 && n_corners != corners_of(type)) {
      throw Error(source, fmt::format("cell {}", cell), fmt::format("{} corners", n_corners),
                  fmt::format("{} (cell type {})", corners_of(type), type));
    }
    for (vtkIdType i = 0; i < n_corners; ++i) {
      if (corners[i] >= 0 && corners[i] < n_points) continue;
      throw Error(source, fmt::format("cell {}", cell), fmt::format("point number {}", corners[i]),
                  fmt::format("one from 0 to {}", n_points - 1));
    }
    if (type == VTK_TETRA) {
      Tet& tet = file.mesh.tets.emplace_back();
      for (std::size_t i = 0; i < tet.size(); ++i) tet[i] = static_cast<Index>(corners[i]);
    } else {
      count_dropped(file, kind_of(type));
    }
  }
}

/// Runs a reader of either class; what goes wrong inside VTK, by message or exception, becomes an Error.
template <class Reader>
MeshFile read_grid(Reader& reader, const std::string& source, const char* expected) {
  VtkErrors errors;
  try {
    reader.Update();
  } catch (const std::exception& error) {
    throw Error(source, "", fmt::format("content that VTK fails on ({})", error.what()), expected);
  }
  if (const std::string message = errors.first(); !message.empty()) {
    throw Error(source, "", fmt::format("content that VTK refuses ({})", message), expected);
  }
  vtkUnstructuredGrid* grid = reader.GetOutput();
  if (grid == nullptr) throw Error(source, "", "no unstructured grid", expected);
  MeshFile file;
  require_valid_cells(*grid, source);
  copy_points(*grid, source, file.mesh);
  copy_cells(*grid, source, file);
  require_tets(file, source);
  return file;
}

}  // namespace

MeshFile read_vtk_legacy(const std::filesystem::path& path) {
  constexpr auto expected = "a VTK legacy unstructured grid";
  const std::string bytes = read_file(path, expected);
  vtkNew<vtkUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  MeshFile file = read_grid(*reader, path.string(), expected);
  file.format = fmt::format("VTK legacy {}", reader->GetFileType() == VTK_BINARY ? "binary" : "ASCII");
  if (reader->GetFileType() != VTK_BINARY) require_line_end(path.string(), bytes);
  return file;
}

MeshFile read_vtu(const std::filesystem::path& path) {
  constexpr auto expected = "a VTK XML unstructured grid";
  const std::string bytes = read_file(path, expected);
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(path.c_str());
  MeshFile file = read_grid(*reader, path.string(), expected);
  file.format = "VTK XML";
  return file;
}

}  // namespace palpate::io

#include <fmt/format.h>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/vtk_cells.hpp"
#include "io/vtk_legacy_file.hpp"
#include "io/xml_scanner.hpp"

namespace palpate::io {

namespace {

VtkLegacyFile read_grid(const std::string& source, const std::string& bytes) {
  VtkLegacyFile vtk = read_vtk_legacy_file(source, bytes);
  if (vtk.dataset == VtkLegacyFile::Dataset::poly_data) {
    throw Error(source, "", "PolyData, a surface",
                "an unstructured grid with tets; 'palpate mesh' makes tets of a surface");
  }
  return vtk;
}

/// Returns how many tets each cell became.
std::vector<Index> append(VtkLegacyFile& vtk, const std::string& source, MeshFile& file) {
  file.mesh.points = std::move(vtk.points);
  std::vector<Index> tets_of_cells =
      append_vtk_cells(vtk.cells, 0, static_cast<Index>(file.mesh.points.size()), 0, source, file);
  require_tets(file, source);
  return tets_of_cells;
}

}  // namespace

MeshFile read_vtk_legacy(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, "a VTK legacy unstructured grid");
  const std::string source = path.string();
  if (is_xml(bytes)) return read_vtu_text(source, bytes);
  VtkLegacyFile vtk = read_grid(source, bytes);
  MeshFile file;
  file.format = vtk.binary ? "VTK legacy binary" : "VTK legacy ASCII";
  append(vtk, source, file);
  return file;
}

std::vector<double> read_vtk_legacy_data(const std::filesystem::path& path, const CellDataKey& key) {
  const std::string bytes = read_file(path, "a VTK legacy unstructured grid");
  const std::string source = path.string();
  if (is_xml(bytes)) return read_vtu_data_text(source, bytes, key);
  VtkLegacyFile vtk = read_grid(source, bytes);
  MeshFile file;
  const std::vector<Index> tets_of_cells = append(vtk, source, file);
  std::vector<double> data;
  append_cell_data(read_vtk_legacy_data(source, bytes, vtk, key), tets_of_cells, data);
  return data;
}

}  // namespace palpate::io

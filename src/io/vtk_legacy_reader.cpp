#include <fmt/format.h>
#include <string>

#include <palpate/error.hpp>

#include "io/cell_counts.hpp"
#include "io/file_bytes.hpp"
#include "io/mesh_formats.hpp"
#include "io/vtk_cells.hpp"
#include "io/vtk_legacy_file.hpp"
#include "io/xml_scanner.hpp"

namespace palpate::io {

MeshFile read_vtk_legacy(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, "a VTK legacy unstructured grid");
  const std::string source = path.string();
  if (is_xml(bytes)) return read_vtu_text(source, bytes);
  VtkLegacyFile vtk = read_vtk_legacy_file(source, bytes);
  if (vtk.dataset == VtkLegacyFile::Dataset::poly_data) {
    throw Error(
        source, "", "PolyData, a surface",
        fmt::format("an unstructured grid with tets; 'palpate mesh {}' makes tets of a surface", source));
  }
  MeshFile file;
  file.format = vtk.binary ? "VTK legacy binary" : "VTK legacy ASCII";
  file.mesh.points = std::move(vtk.points);
  append_vtk_cells(vtk.cells, 0, static_cast<Index>(file.mesh.points.size()), 0, source, file);
  require_tets(file, source);
  return file;
}

}  // namespace palpate::io

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

#include "io/vtk_cells.hpp"

/// The readers behind read_mesh(), one a format; each keeps read_mesh()'s promises.
namespace palpate::io {

/// Gmsh MSH file format 1, 2 to 2.2, 4.0 and 4.1 (Gmsh reference manual, "MSH file format"); 3 is refused.
MeshFile read_gmsh(const std::filesystem::path& path);

/// Medit ASCII (INRIA RT-0253, "MEDIT: an interactive mesh visualization software", appendix). The closing
/// keyword End is required: nothing else distinguishes a complete file from one that was cut in its last
/// number.
MeshFile read_medit(const std::filesystem::path& path);

/// TetGen .node and .ele (TetGen manual, "File formats"), given by either path. Numbering starts at 0 or 1
/// and has no gaps.
MeshFile read_tetgen(const std::filesystem::path& path);

/// VTK legacy unstructured grid, ASCII or binary, file versions up to 5.1 (VTK file formats, "Simple legacy
/// formats"), or XML as read_vtu() takes it. Data after the cells (point and cell data) are not read.
/// An ASCII file must end with a line end: the format has no end mark.
MeshFile read_vtk_legacy(const std::filesystem::path& path);

/// VTK XML unstructured grid (VTK file formats, "XML file formats"): ASCII, binary, appended raw or base64;
/// plain, zlib, LZ4 or LZMA; both byte orders and header types. Pieces are joined; equal points of two pieces
/// are not merged.
MeshFile read_vtu(const std::filesystem::path& path);
/// read_vtu() for the text of a file; `source` is its name for messages.
MeshFile read_vtu_text(const std::string& source, std::string_view text);

/// The readers behind read_cell_data(), one for each format; each keeps its promises.
std::vector<double> read_gmsh_data(const std::filesystem::path& path, const CellDataKey& key);
std::vector<double> read_vtk_legacy_data(const std::filesystem::path& path, const CellDataKey& key);
std::vector<double> read_vtu_data(const std::filesystem::path& path, const CellDataKey& key);
/// read_vtu_data() for the text of a file; `source` is its name for messages.
std::vector<double> read_vtu_data_text(const std::string& source, std::string_view text,
                                       const CellDataKey& key);

}  // namespace palpate::io

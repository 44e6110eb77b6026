#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// The polygons of a file.
struct PolygonFile {
  std::vector<Vec3> points;                  ///< finite
  std::vector<std::vector<Index>> polygons;  ///< points of each, in [0, n_points)
};

/// The extensions that read_surface_file() reads, for messages: ".stl .obj .ply .off .vtk .vtp".
inline constexpr std::string_view surface_extensions = ".stl .obj .ply .off .vtk .vtp";

/// Whether a file has the extension of a surface. A .vtk file may hold tets as well.
bool is_surface(const std::filesystem::path& path);

/// Reads the polygons of such a file. Throws Error if the format is another one or the file is damaged.
/// O(file size). The readers are our own, since those of VTK 9.1 end the process on damaged files of each of
/// these formats.
PolygonFile read_surface_file(const std::filesystem::path& path);

// One reader for each format.
// \param bytes  content of the file
// \param source  its name, for messages

/// Triangles, text or binary. Each triangle has its own points. A text may have "end solid" for "endsolid".
/// (3D Systems, "StereoLithography Interface Specification", 1988)
PolygonFile read_stl(const std::string& source, std::string_view bytes);

/// Reads the lines "v" and "f" and skips all others. (Wavefront, "Object Files (.obj)", appendix B1)
PolygonFile read_obj(const std::string& source, std::string_view bytes);

/// The elements "vertex" (x, y, z) and "face" (a list vertex_indices or vertex_index), text or binary; all
/// else is passed over. (G. Turk, "The PLY Polygon File Format", 1994)
PolygonFile read_ply(const std::string& source, std::string_view bytes);

/// Points and polygons of text, with counts of points, polygons and edges before them; what follows x, y and
/// z and the corners of a polygon (normals, colours) is passed over. (Geomview manual, "OFF Files")
PolygonFile read_off(const std::string& source, std::string_view bytes);

/// Polygons and triangle strips of VTK's legacy PolyData, text or binary, as 3D Slicer writes it; triangles,
/// quads and polygons of an unstructured grid without tets; or XML as read_vtp() takes it. (VTK file formats,
/// "Simple legacy formats")
PolygonFile read_vtk(const std::string& source, std::string_view bytes);

/// Points, polygons and triangle strips of VTK's XML files of PolyData, in each of their encodings.
PolygonFile read_vtp(const std::string& source, std::string_view bytes);

}  // namespace palpate::app

#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::app {

/// Polygons as a file has them.
struct PolygonFile {
  std::vector<Vec3> points;                  ///< finite
  std::vector<std::vector<Index>> polygons;  ///< points of each, in [0, n_points)
};

/// Whether a file's name ends as one of a surface does: .stl, .obj, .ply or .vtp.
bool is_surface(const std::filesystem::path& path);

/// The polygons in such a file. Throws Error where it is none, or not whole. O(file size). (Readers of our
/// own: those of VTK 9.1 end the process on damaged files of each of these formats, which is why none of them
/// sees one.)
PolygonFile read_surface_file(const std::filesystem::path& path);

// One for each format. They take the bytes of the file, and its name for messages.

/// Triangles, text or binary; each has points of its own. (3D Systems, "StereoLithography Interface
/// Specification", 1988)
PolygonFile read_stl(const std::string& source, std::string_view bytes);

/// The lines "v" and "f"; all others are passed over. (Wavefront, "Object Files (.obj)", appendix B1)
PolygonFile read_obj(const std::string& source, std::string_view bytes);

/// The elements "vertex" (x, y, z) and "face" (a list vertex_indices or vertex_index), text or binary; all
/// else is passed over. (G. Turk, "The PLY Polygon File Format", 1994)
PolygonFile read_ply(const std::string& source, std::string_view bytes);

/// Points and Polys of VTK's XML files of PolyData, in each of their encodings; no strips.
PolygonFile read_vtp(const std::string& source, std::string_view bytes);

}  // namespace palpate::app

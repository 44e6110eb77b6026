#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/io/mesh_reader.hpp>

namespace palpate::io {

/// Adds to the count of a dropped kind of cell. `kind` in the singular: "triangle", "tetrahedron10".
void count_dropped(MeshFile& file, std::string_view kind, Index count = 1);

/// Number of dropped cells that are solids, so that the mesh lacks their volume: those without a fixed number
/// of faces.
Index dropped_solids(const std::vector<std::pair<std::string, Index>>& dropped);

/// Throws Error if the file has no point or no tet; the message counts what it has instead ("found 360
/// triangles and no tet, expected at least one tet").
void require_tets(const MeshFile& file, const std::string& source);

}  // namespace palpate::io

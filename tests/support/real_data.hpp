#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <palpate/io/mesh_reader.hpp>

#include "geometry/box.hpp"

namespace palpate::test {

/// The folder of data that we may not ship: PALPATE_TEST_DATA, or the default beside the project. Tests that
/// need it are skipped without it.
inline std::filesystem::path real_data_folder() {
  const char* folder = std::getenv("PALPATE_TEST_DATA");
  return folder != nullptr ? folder : std::filesystem::path(PALPATE_SOURCE_DIR) / ".." / "shared" / "data";
}

/// A mesh of this folder, centred, scaled so that the longest side of its box is `size`.
inline TetMesh real_mesh(const std::filesystem::path& name, double size) {
  TetMesh mesh = io::read_mesh(real_data_folder() / "meshes" / name).mesh;
  Box box;
  for (const Vec3& p : mesh.points) box.extend(p);
  const Vec3 sides = box.upper - box.lower;
  const double scale = size / std::max({sides.x, sides.y, sides.z});
  for (Vec3& p : mesh.points) p = scale * (p - 0.5 * (box.lower + box.upper));
  return mesh;
}

}  // namespace palpate::test

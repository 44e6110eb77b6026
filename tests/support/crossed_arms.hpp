#pragma once

#include <array>
#include <cmath>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate::test {

/// Half of the side of the square sections of crossed_arms(), m.
inline constexpr double half_of_arm = 0.01;

/// One bar, bent so that its two arms cross: the lower arm along x through the origin, up a slope beside it,
/// and back along y over the middle of the lower arm, where the surfaces are `gap` apart (below 0: deep).
/// Sections have one cell.
inline TetMesh crossed_arms(double gap) {
  const double top = 2.0 * half_of_arm + gap;
  const std::array<Vec3, 5> corners{Vec3{-0.1, 0.0, 0.0}, Vec3{0.12, 0.0, 0.0}, Vec3{0.12, 0.12, 0.5 * top},
                                    Vec3{0.003, 0.12, top}, Vec3{0.003, -0.08, top}};
  constexpr std::array cells{3, 3, 3, 4};
  std::vector<Vec3> line{corners[0]};
  for (std::size_t k = 0; k < cells.size(); ++k) {
    for (int i = 1; i <= cells[k]; ++i)
      line.push_back(corners[k] + double(i) / cells[k] * (corners[k + 1] - corners[k]));
  }
  const int n = static_cast<int>(line.size()) - 1;
  TetMesh mesh = box_mesh({n, 1, 1}, {0, -half_of_arm, -half_of_arm}, {double(n), half_of_arm, half_of_arm});
  for (Vec3& p : mesh.points) {
    const auto i = static_cast<std::size_t>(std::lround(p.x));
    const Vec3 before = i > 0 ? normalized(line[i] - line[i - 1]) : Vec3{};
    const Vec3 after = i + 1 < line.size() ? normalized(line[i + 1] - line[i]) : Vec3{};
    const Vec3 along = normalized(before + after);
    const Vec3 left = normalized(cross(Vec3{0, 0, 1}, along));
    const double mitre = i > 0 && i + 1 < line.size() ? 1.0 / dot(along, before) : 1.0;
    p = line[i] + mitre * p.y * left + Vec3{0, 0, p.z};
  }
  return mesh;
}

}  // namespace palpate::test

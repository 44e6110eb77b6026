#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "support/random.hpp"

namespace palpate::test {

/// A single body called "body".
inline Bodies single_body(TetMesh mesh) {
  Bodies bodies;
  bodies.add("body", std::move(mesh));
  return bodies;
}

/// A box of nx x ny x nz cells with 6 tets a cell (Kuhn); not the library's own 5-tet generator.
inline TetMesh box_mesh(std::array<int, 3> cells, const Vec3& lower, const Vec3& upper) {
  TetMesh mesh;
  const auto [nx, ny, nz] = cells;
  const auto index = [nx = nx, ny = ny](int i, int j, int k) { return i + (nx + 1) * (j + (ny + 1) * k); };
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        mesh.points.push_back({lower.x + (upper.x - lower.x) * i / nx, lower.y + (upper.y - lower.y) * j / ny,
                               lower.z + (upper.z - lower.z) * k / nz});
      }
    }
  }
  constexpr int paths[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const auto& path : paths) {
          std::array<int, 3> at_cell{i, j, k};
          Tet tet{index(i, j, k), 0, 0, 0};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at_cell[static_cast<std::size_t>(path[s])];
            tet[s + 1] = index(at_cell[0], at_cell[1], at_cell[2]);
          }
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  return mesh;
}

/// A ball: the box mesh of [-1, 1]^3 with each point moved along its ray so that cubes become spheres.
inline TetMesh ball_mesh(int cells, const Vec3& centre, double radius) {
  TetMesh mesh = box_mesh({cells, cells, cells}, {-1, -1, -1}, {1, 1, 1});
  for (Vec3& p : mesh.points) {
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    const double l = length(p);
    p = centre + (l > 0.0 ? radius * largest / l : 0.0) * p;
  }
  return mesh;
}

/// One mesh of two, which share nothing.
inline TetMesh joined(TetMesh mesh, const TetMesh& other) {
  const auto first = static_cast<Index>(mesh.points.size());
  mesh.points.insert(mesh.points.end(), other.points.begin(), other.points.end());
  for (Tet tet : other.tets) {
    for (Index& corner : tet) corner += first;
    mesh.tets.push_back(tet);
  }
  return mesh;
}

/// Rotates about an axis through the origin (Rodrigues).
inline Vec3 rotated(const Vec3& p, const Vec3& axis, double angle) {
  const Vec3 n = normalized(axis);
  return std::cos(angle) * p + std::sin(angle) * cross(n, p) + (1.0 - std::cos(angle)) * dot(n, p) * n;
}

/// Random tets without common points: `point` makes a corner. Tets without volume are left out.
template <class MakePoint>
TetMesh soup(int tets, MakePoint&& make_point) {
  TetMesh mesh;
  while (static_cast<int>(mesh.tets.size()) < tets) {
    const auto first = static_cast<Index>(mesh.points.size());
    const std::array<Vec3, 4> p{make_point(), make_point(), make_point(), make_point()};
    if (orient3d(p[0], p[1], p[2], p[3]) == 0) continue;
    mesh.points.insert(mesh.points.end(), p.begin(), p.end());
    mesh.tets.push_back({first, first + 1, first + 2, first + 3});
  }
  return mesh;
}

}  // namespace palpate::test

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

/// Meshes of round bodies for the tests of large strains.
namespace palpate::fem::test {

inline void put_tet(TetMesh& mesh, Tet tet) {
  const auto corner = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(tet[k])]; };
  const Vec3 a = corner(0);
  if (dot(corner(1) - a, cross(corner(2) - a, corner(3) - a)) < 0.0) std::swap(tet[2], tet[3]);
  mesh.tets.push_back(tet);
}

/// A thick spherical shell: an octahedron with n edges a side, blown up, in layers of three tets a prism.
inline TetMesh shell_mesh(int n, int layers, double inner, double outer) {
  std::map<std::array<int, 3>, Index> number;
  std::vector<Vec3> directions;
  std::vector<std::array<Index, 3>> triangles;
  const auto put = [&](const std::array<int, 3>& p) {
    const auto [at, fresh] = number.try_emplace(p, static_cast<Index>(directions.size()));
    if (fresh)
      directions.push_back(
          normalized(Vec3{static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])}));
    return at->second;
  };
  for (const int x : {-1, 1}) {
    for (const int y : {-1, 1}) {
      for (const int z : {-1, 1}) {
        const auto point = [&](int i, int j) { return put({x * i, y * j, z * (n - i - j)}); };
        for (int i = 0; i < n; ++i) {
          for (int j = 0; i + j < n; ++j) {
            triangles.push_back({point(i, j), point(i + 1, j), point(i, j + 1)});
            if (i + j + 1 < n) triangles.push_back({point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)});
          }
        }
      }
    }
  }
  TetMesh mesh;
  const auto around = static_cast<Index>(directions.size());
  for (int layer = 0; layer <= layers; ++layer) {
    const double radius = inner + (outer - inner) * layer / layers;
    for (const Vec3& d : directions) mesh.points.push_back(radius * d);
  }
  for (Index layer = 0; layer < layers; ++layer) {
    for (std::array<Index, 3> t : triangles) {
      std::sort(t.begin(), t.end());
      const Index b = layer * around;
      const Index a = b + around;
      put_tet(mesh, {b + t[0], b + t[1], b + t[2], a + t[2]});
      put_tet(mesh, {b + t[0], b + t[1], a + t[2], a + t[1]});
      put_tet(mesh, {b + t[0], a + t[2], a + t[1], a + t[0]});
    }
  }
  return mesh;
}

/// A cylinder along z from 0 to `height`: a box whose squares become discs.
inline TetMesh cylinder_mesh(int across, int along, double radius, double height) {
  TetMesh mesh = palpate::test::box_mesh({across, across, along}, {-1, -1, 0}, {1, 1, height});
  for (Vec3& p : mesh.points) {
    const double x = p.x * std::sqrt(1.0 - 0.5 * p.y * p.y);
    const double y = p.y * std::sqrt(1.0 - 0.5 * p.x * p.x);
    p = {radius * x, radius * y, p.z};
  }
  return mesh;
}

}  // namespace palpate::fem::test

#include "mesh_program/conforming.hpp"

#include <algorithm>

namespace palpate::test {
namespace {

PlacedTriangle placed(const TetMesh& mesh, std::array<Index, 3> corners) {
  PlacedTriangle triangle{};
  for (std::size_t c = 0; c < 3; ++c) {
    const Vec3& p = mesh.points[static_cast<std::size_t>(corners[c])];
    triangle[c] = {p.x, p.y, p.z};
  }
  std::ranges::rotate(triangle, std::ranges::min_element(triangle));
  return triangle;
}

}  // namespace

PlacedTriangle turned(const PlacedTriangle& triangle) {
  return {triangle[0], triangle[2], triangle[1]};
}

std::set<PlacedTriangle> surface_of(const TetMesh& mesh) {
  std::set<PlacedTriangle> open;
  for (const Tet& t : mesh.tets) {
    for (const auto& face : {std::array{t[1], t[2], t[3]}, std::array{t[0], t[3], t[2]},
                             std::array{t[0], t[1], t[3]}, std::array{t[0], t[2], t[1]}}) {
      const PlacedTriangle triangle = placed(mesh, face);
      if (open.erase(turned(triangle)) > 0) continue;
      EXPECT_TRUE(open.insert(triangle).second) << "a face of three";
    }
  }
  return open;
}

}  // namespace palpate::test

// Two boxes of hand-written tets, one sunk halfway into the other, and what palpate says of them.
#include <cstdio>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

namespace {

/// A unit cube of five tets with its lowest corner at (0, 0, height).
palpate::TetMesh box(double height) {
  palpate::TetMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.points.push_back({double(corner & 1), double((corner >> 1) & 1), height + double(corner >> 2)});
  }
  mesh.tets = {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
  return mesh;
}

}  // namespace

int main() try {
  palpate::Bodies bodies;
  bodies.add("lower", box(0.0));
  bodies.add("upper", box(0.5));
  const palpate::MeshStatistics both = palpate::mesh_statistics(bodies, bodies.points_rest());
  std::printf("points %d, edges %d, triangles %d, tets %d, volume %g\n", both.points, both.edges,
              both.triangles, both.tets, both.volume);
  return 0;
} catch (const palpate::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

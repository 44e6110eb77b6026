// Two boxes of hand-written tets, one sunk a little into the other, and the contacts that palpate finds.
#include <cstdio>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

namespace {

/// A unit cube of five tets with its lowest corner at (shift, shift, height).
palpate::TetMesh box(double shift, double height) {
  palpate::TetMesh mesh;
  for (int corner = 0; corner < 8; ++corner) {
    mesh.points.push_back({shift + (corner & 1), shift + ((corner >> 1) & 1), height + (corner >> 2)});
  }
  mesh.tets = {{0, 1, 2, 4}, {3, 2, 1, 7}, {5, 4, 7, 1}, {6, 7, 4, 2}, {1, 2, 4, 7}};
  return mesh;
}

}  // namespace

int main() try {
  palpate::Bodies bodies;
  bodies.add("lower", box(0.0, 0.0));
  bodies.add("upper", box(0.3, 0.9));
  palpate::Detector detector(bodies, {});
  detector.detect(bodies.points_rest());  // any positions of the points: each frame of a simulation
  const palpate::Contacts& contacts = detector.contacts();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const palpate::Vec3 out = contacts.direction[c];
    std::printf("point %d is %.3f deep in body %d, out: (%.2f, %.2f, %.2f)\n", contacts.point[c],
                contacts.depth[c], contacts.body[c], out.x, out.y, out.z);
  }
  return 0;
} catch (const palpate::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>

#include "contact/sweep.hpp"
#include "io/mesh_reader.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

constexpr int steps = 1000;

/// Moves body 1 from `-travel / 2` to `travel / 2`.
test::SweepReport pass_through(const Bodies& bodies, const Vec3& travel) {
  Detector detector(bodies, {}, {}, 1);
  const Range moving = at(bodies.bodies(), 1).points;
  return test::sweep(bodies, detector, steps, [&](int step, std::vector<Vec3>& x) {
    const double s = step / (steps - 1.0) - 0.5;
    for (Index p = moving.begin; p < moving.end; ++p) at(x, p) = at(bodies.points_rest(), p) + s * travel;
  });
}

void print(const char* name, const Bodies& bodies, const test::SweepReport& r) {
  const double h = mesh_statistics(bodies, bodies.points_rest(), 0).edge_length.mean;
  std::printf("%s: h %.3g pairs %zu motion/h %.4f deepest/h %.3f fallbacks %zu | depth jump/h %.4f (x motion %.1f) "
              "step %d point %d | turn %.2f deg step %d point %d\n",
              name, h, r.pairs, r.largest_motion / h, r.deepest / h, r.fallbacks, r.depth.size / h,
              r.depth.size / r.largest_motion, r.depth.step, r.depth.point, r.direction.size, r.direction.step,
              r.direction.point);
  std::printf("   ms/step: contacts %.3f crossings %.3f depth %.3f\n", r.times.contacts, r.times.crossings, r.times.depth);
}

TetMesh turned(TetMesh mesh, const Vec3& axis, double angle) {
  for (Vec3& p : mesh.points) p = test::rotated(p, axis, angle);
  return mesh;
}

TEST(Sweep, BoxThroughBox) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({6, 6, 6}, {-1, -1, -1}, {1, 1, 1}));
  bodies.add("bar", turned(test::box_mesh({3, 3, 14}, {-0.41, -0.45, -2.4}, {0.43, 0.4, 2.5}), {1, 2, 3}, 0.2));
  print("box/box", bodies, pass_through(bodies, {4.0, 0.3, 0.2}));
}

TEST(Sweep, BallThroughBall) {
  Bodies bodies;
  bodies.add("ball", test::ball_mesh(8, {0, 0, 0}, 1.0));
  bodies.add("other", turned(test::ball_mesh(8, {0.02, 0.51, 0.03}, 0.8), {1, 2, 3}, 0.01));
  print("ball/ball", bodies, pass_through(bodies, {4.0, 0.01, 0.02}));
}

TetMesh organ(const char* name) {
  const char* folder = std::getenv("PALPATE_TEST_DATA");
  const std::filesystem::path data =
      folder != nullptr ? folder : std::filesystem::path(PALPATE_SOURCE_DIR) / ".." / "shared" / "data";
  TetMesh mesh = io::read_mesh(data / "meshes" / name).mesh;
  Vec3 lower = mesh.points[0];
  Vec3 upper = lower;
  for (const Vec3& p : mesh.points) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  const double size = std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z});
  for (Vec3& p : mesh.points) p = (1.0 / size) * (p - 0.5 * (lower + upper));
  return mesh;
}

TEST(Sweep, OrganThroughOrgan) {
  for (const char* name : {"liver.msh", "liver2.msh", "Ossicles.vtu"}) {
    Bodies bodies;
    bodies.add("organ", organ(name));
    bodies.add("other", turned(organ(name), {1, 2, 3}, 1.0));
    print(name, bodies, pass_through(bodies, {1.7, 0.1, 0.05}));
  }
}

}  // namespace
}  // namespace palpate

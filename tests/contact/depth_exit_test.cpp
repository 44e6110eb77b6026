// The exit leads out: a point of a deep contact, moved along its direction by its depth and 1e-6 m, is
// outside the body that it was in. Oracle: all tets of that body, by volumes where those are far above
// rounding and in rational arithmetic elsewhere.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"
#include "support/rational.hpp"
#include "support/real_data.hpp"

namespace palpate {
namespace {

constexpr double beyond = 1e-6;  // m
constexpr double most_inside = 0.01;

double volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a);
}

bool is_in_box(const Vec3& p, const std::array<Vec3, 4>& t) {
  for (const auto along : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    const auto [least, most] = std::minmax({t[0].*along, t[1].*along, t[2].*along, t[3].*along});
    if (p.*along < least || p.*along > most) return false;
  }
  return true;
}

bool is_in_tet(const Vec3& p, const std::array<Vec3, 4>& t) {
  if (!is_in_box(p, t)) return false;
  double size = std::max(length(p), length(t[0]));
  for (std::size_t i = 1; i < 4; ++i) size = std::max(size, length(t[i] - t[0]));
  const double rounding = 1e-14 * size * size * size;
  const double whole = volume(t[0], t[1], t[2], t[3]);
  bool sure = std::abs(whole) > rounding;
  for (const double part : {volume(p, t[1], t[2], t[3]), volume(t[0], p, t[2], t[3]),
                            volume(t[0], t[1], p, t[3]), volume(t[0], t[1], t[2], p)}) {
    if (sure && std::abs(part) > rounding && (part > 0.0) != (whole > 0.0)) return false;
    sure = sure && std::abs(part) > rounding;
  }
  return sure || test::rational_point_in_tet(p, t[0], t[1], t[2], t[3]);
}

bool is_inside(const Bodies& bodies, std::span<const Vec3> x, Index body, const Vec3& p) {
  const Range tets = at(bodies.bodies(), body).tets;
  for (Index t = tets.begin; t < tets.end; ++t) {
    const Tet& c = at(bodies.tets(), t);
    if (is_in_tet(p, {at(x, c[0]), at(x, c[1]), at(x, c[2]), at(x, c[3])})) return true;
  }
  return false;
}

/// Where the exits of contacts end.
struct Ends {
  std::size_t contacts = 0;
  std::size_t inside = 0;
  std::size_t deep_inside = 0;  ///< of these, by more than 0.1 edge

  [[nodiscard]] double fraction_inside() const {
    return static_cast<double>(inside) / static_cast<double>(contacts);
  }
  Ends& operator+=(const Ends& other) {
    contacts += other.contacts;
    inside += other.inside;
    deep_inside += other.deep_inside;
    return *this;
  }
};

/// Of two bodies at rest. Also expects that no depth is less than the distance to the surface.
Ends ends_of(TetMesh a, TetMesh b) {
  Bodies bodies;
  bodies.add("a", std::move(a));
  bodies.add("b", std::move(b));
  Detector detector(bodies, {}, {}, 2);
  const std::span<const Vec3> x = bodies.points_rest();
  detector.detect(x);
  const Contacts& contacts = detector.contacts();
  Ends ends;
  ends.contacts = contacts.size();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index body = contacts.body[c];
    const Vec3& p = at(x, contacts.point[c]);
    const double nearest = nearest_surface_point(bodies, x, body, p).distance;
    EXPECT_GE(contacts.depth[c], nearest * (1.0 - 1e-8) - 1e-12);
    EXPECT_NEAR(length(contacts.direction[c]), 1.0, 1e-12);
    const Vec3 end = p + (contacts.depth[c] + beyond) * contacts.direction[c];
    if (!is_inside(bodies, x, body, end)) continue;
    ++ends.inside;
    const double edge = mesh_statistics(bodies, x, body).edge_length.mean;
    ends.deep_inside += nearest_surface_point(bodies, x, body, end).distance > 0.1 * edge ? 1 : 0;
  }
  return ends;
}

void expect_outside(const std::string& name, const Ends& ends) {
  std::printf("%-22s %5zu contacts, %4zu ways end inside (%.2f %%), %zu by more than 0.1 edge\n",
              name.c_str(), ends.contacts, ends.inside, 100.0 * ends.fraction_inside(), ends.deep_inside);
  EXPECT_GT(ends.contacts, 2000U) << name;
  EXPECT_LE(ends.fraction_inside(), most_inside) << name;
}

TetMesh placed(TetMesh mesh, double scale, const Vec3& axis, double angle, const Vec3& by) {
  for (Vec3& p : mesh.points) p = scale * test::rotated(p, axis, angle) + by;
  return mesh;
}

constexpr std::array files{"liver.msh",
                           "liver2.msh",
                           "Ossicles.vtu",
                           "Armadillo_Tetra_4406.vtu",
                           "raptorTetra_8418.vtu",
                           "seaMonster2-volume1.vtu",
                           "volumetricTongue.vtu"};

TetMesh organ(const std::string& file) {
  return test::real_mesh(file, 0.2);
}

class DepthExitOfOrgans : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* file : files) {
      const std::filesystem::path path = test::real_data_folder() / "meshes" / file;
      if (!std::filesystem::exists(path))
        GTEST_SKIP() << "no mesh " << path << ": set PALPATE_TEST_DATA to where they are";
    }
  }
};

TEST(DepthExit, OfBallsFourCentimetresDeep) {
  Ends all;
  for (const int cells : {4, 8, 12}) {
    for (const double angle : {0.0, 0.7}) {
      const TetMesh ball = test::ball_mesh(cells, {0, 0, 0}, 0.05);
      all += ends_of(ball, placed(ball, 1.0, {1, 2, 3}, angle, {0.011, 0.013, 0.0575}));
    }
  }
  expect_outside("balls", all);
}

TEST_F(DepthExitOfOrgans, SwallowedByABoxABallAndALiver) {
  Ends box;
  Ends ball;
  Ends liver;
  for (const std::string file : files) {
    const TetMesh inner = organ(file);
    box += ends_of(test::box_mesh({8, 8, 8}, {-0.12, -0.12, -0.12}, {0.12, 0.12, 0.12}), inner);
    ball += ends_of(test::ball_mesh(8, {0, 0, 0}, 0.13), inner);
    if (file == "liver2.msh") continue;
    liver += ends_of(placed(organ("liver2.msh"), 2.0, {1, 2, 3}, 0.4, {}),
                     placed(inner, 0.6, {1, 0, 0}, 0.3, {0.02, 0, 0}));
  }
  expect_outside("organs in a box", box);
  expect_outside("organs in a ball", ball);
  expect_outside("organs in a liver", liver);
}

TEST_F(DepthExitOfOrgans, InTheirShiftedCopies) {
  Ends all;
  for (const char* file : files) {
    for (const double shift : {0.003, 0.01, 0.03}) {
      const TetMesh mesh = organ(file);
      all += ends_of(mesh, placed(mesh, 1.0, {1, 0, 0}, 0.0, shift * Vec3{0.6, 0.48, 0.64}));
    }
  }
  expect_outside("shifted copies", all);
}

TEST_F(DepthExitOfOrgans, InRandomPairs) {
  test::Random random(7);
  const auto any = [&] { return organ(at(files, random.integer(0, static_cast<int>(files.size()) - 1))); };
  Ends all;
  for (int i = 0; i < 40; ++i) {
    const TetMesh a = any();
    const TetMesh b = any();
    const double scale = random.uniform(0.5, 1.5);
    const Vec3 axis = random.point(-1, 1);
    const double angle = random.uniform(0, 3);
    all += ends_of(a, placed(b, scale, axis, angle, random.point(-0.05, 0.05)));
  }
  expect_outside("random pairs", all);
}

TEST(DepthExit, OfShallowContactsIsTheMeanPlane) {
  // A ball in a flat box, 0.09 edges deep: every plane is that of the flat top, to the bit.
  Bodies bodies;
  bodies.add("box", test::box_mesh({4, 4, 2}, {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.0}));
  const double edge = mesh_statistics(bodies, bodies.points_rest(), 0).edge_length.mean;
  bodies.add("ball", test::ball_mesh(8, {0.003, 0.002, 0.05 - 0.09 * edge}, 0.05));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  const Contacts& contacts = detector.contacts();
  std::size_t checked = 0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts.body[c] != 0) continue;
    ++checked;
    EXPECT_NEAR(contacts.depth[c], -at(bodies.points_rest(), contacts.point[c]).z, 1e-15);
    EXPECT_NEAR(contacts.direction[c].z, 1.0, 1e-14);
  }
  EXPECT_GT(checked, 3U);
}

}  // namespace
}  // namespace palpate

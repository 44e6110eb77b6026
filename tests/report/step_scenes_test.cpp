// The scenes that `palpate bench step` generates: flatness of slivers and numbers of tets agree with the
// names.
#include <cmath>
#include <gtest/gtest.h>
#include <set>

#include <palpate/mesh.hpp>

#include "scene/generators.hpp"
#include "steps/catalogue.hpp"
#include "steps/slivers.hpp"

namespace palpate::bench {
namespace {

TEST(StepScenes, AnglesOfARegularTetAreKnown) {
  // The cosine of its dihedral angle is 1/3.
  const double sine = flattest_sine({{{1, 1, 1}, {1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}}});
  EXPECT_NEAR(std::abs(sine), std::sqrt(8.0) / 3.0, 1e-14);
  EXPECT_LT(flattest_sine({{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}}}), 0.0) << "mirrored";
}

TEST(StepScenes, SliversHaveTheAnglesThatTheySay) {
  const TetMesh regular = make_ball(0.05, 5);
  TetMesh mesh = regular;
  make_slivers(mesh, 3);
  Bodies bodies;
  bodies.add("slivers", mesh);
  EXPECT_EQ(bodies.notes()[0].reoriented_tets, 0) << "a tet is inside out";
  const MeshStatistics is = mesh_statistics(bodies, bodies.points_rest());
  const double flattest = std::min(is.dihedral_angle.min, 180.0 - is.dihedral_angle.max);
  EXPECT_GE(flattest, 0.2 - 1e-4);
  EXPECT_LE(flattest, 0.2 + 1e-4);
  // Moving points inside moves no volume.
  Bodies before;
  before.add("ball", regular);
  EXPECT_NEAR(is.volume, mesh_statistics(before, before.points_rest()).volume, 1e-12);
  std::size_t slivers = 0;
  for (const Tet& tet : mesh.tets) {
    const auto corner = [&](std::size_t k) { return mesh.points[static_cast<std::size_t>(tet[k])]; };
    if (flattest_sine({corner(0), corner(1), corner(2), corner(3)}) < 0.0872) ++slivers;
  }
  EXPECT_GT(slivers, mesh.tets.size() / 50);
}

TEST(StepScenes, SurfacesStay) {
  const TetMesh regular = make_ball(0.05, 4);
  TetMesh mesh = regular;
  make_slivers(mesh, 1);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const bool outside = i >= 1 + 12 + 42 + 92;
    if (outside) {
      EXPECT_EQ(mesh.points[i], regular.points[i]) << i;
    }
    if (!(mesh.points[i] == regular.points[i])) ++moved;
  }
  EXPECT_GT(moved, 100U);
}

TEST(StepScenes, NamesAreUniqueAndSizesTrue) {
  std::set<std::string> names;
  for (const StepScene& scene : generated_scenes()) {
    EXPECT_TRUE(names.insert(scene.name).second) << scene.name;
    EXPECT_GT(scene.steps, 0) << scene.name;
    EXPECT_GT(scene.quick_steps, 0) << scene.name;
    if (scene.tets > 20000) continue;  // the others are made by the same functions
    EXPECT_EQ(scene.make().model.bodies.tets().size(), scene.tets) << scene.name;
  }
  EXPECT_GE(names.size(), 30U);
}

TEST(StepScenes, WhatIsNotThereIsSaid) {
  const StepCatalogue catalogue = step_catalogue({.scenes = "nowhere", .rough = {}, .skull = {}});
  EXPECT_EQ(catalogue.scenes.size(), generated_scenes().size());
  ASSERT_EQ(catalogue.absent.size(), 8U);
  EXPECT_EQ(catalogue.absent[0].name, "stacking");
  EXPECT_EQ(catalogue.absent[0].reason, "no 'nowhere/stacking.json'");
}

}  // namespace
}  // namespace palpate::bench

// The meshes of the medical scenes: the paper's Table 1, quality, and that the generator reproduces the
// committed files.
#include "anatomy/organs.hpp"

#include <filesystem>
#include <gtest/gtest.h>

#include <palpate/io/mesh_reader.hpp>

#include "anatomy/surface.hpp"

namespace palpate::anatomy {
namespace {

struct Table1 {
  double points, edges, triangles, tets;
};

std::filesystem::path folder(const std::string& scene) {
  return std::filesystem::path(PALPATE_SOURCE_DIR) / "scenes" / "meshes" / scene;
}

Bodies committed(const std::string& scene) {
  Bodies bodies;
  for (const auto& entry : std::filesystem::directory_iterator(folder(scene)))
    bodies.add(entry.path().stem().string(), io::read_mesh(entry.path()).mesh);
  return bodies;
}

void expect_like(const MeshStatistics& found, const Table1& paper) {
  const auto near = [](double value, double wanted, double fraction) {
    EXPECT_NEAR(value, wanted, fraction * wanted);
  };
  near(found.tets, paper.tets, 0.05);
  near(found.points, paper.points, 0.2);
  near(found.edges, paper.edges, 0.2);
  near(found.triangles, paper.triangles, 0.2);
}

void expect_good(const std::string& scene, const Table1& paper) {
  const Bodies bodies = committed(scene);
  const MeshStatistics all = mesh_statistics(bodies, bodies.points_rest());
  expect_like(all, paper);
  EXPECT_GE(all.dihedral_angle.min, 8.0);
  for (Index b = 0; b < bodies.body_count(); ++b) {
    const test::SurfaceCheck surface = test::surface_check(bodies, b);
    EXPECT_TRUE(surface.closed) << at(bodies.bodies(), b).name;
    EXPECT_EQ(surface.odd_edges, 0) << at(bodies.bodies(), b).name;
    EXPECT_EQ(at(bodies.notes(), b).unreferenced_points, 0);
  }
}

void expect_committed(const std::string& scene, const std::vector<Organ>& organs) {
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder(scene))) ++files;
  EXPECT_EQ(organs.size(), files);
  for (const Organ& organ : organs) {
    const TetMesh mesh = io::read_mesh(folder(scene) / (organ.name + ".vtu")).mesh;
    EXPECT_EQ(organ.mesh.points, mesh.points) << organ.name;
    EXPECT_EQ(organ.mesh.tets, mesh.tets) << organ.name;
  }
}

TEST(Eye, IsThePapersTableOneAndOfGoodQuality) {
  expect_good("eye", {3167, 16248, 6472, 9819});
}
TEST(Skull, IsThePapersTableOneAndOfGoodQuality) {
  expect_good("skull", {8293, 38352, 13592, 23225});
}
TEST(Eye, GeneratorGivesTheCommittedMeshes) {
  expect_committed("eye", make_eye());
}
TEST(Skull, GeneratorGivesTheCommittedMeshes) {
  expect_committed("skull", make_skull());
}

}  // namespace
}  // namespace palpate::anatomy

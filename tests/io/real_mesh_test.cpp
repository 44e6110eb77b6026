#include <algorithm>
#include <filesystem>
#include <gtest/gtest.h>

#include <palpate/io/mesh_reader.hpp>

#include "support/real_data.hpp"

namespace palpate::io {
namespace {

class RealMesh : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(test::real_data_folder() / "meshes")) {
      GTEST_SKIP() << "no folder " << test::real_data_folder()
                   << ": set PALPATE_TEST_DATA to where the real meshes are";
    }
  }

  static MeshFile expect_counts(const char* name, std::size_t points, std::size_t tets) {
    MeshFile file = read_mesh(test::real_data_folder() / name);
    EXPECT_EQ(file.mesh.points.size(), points) << name;
    EXPECT_EQ(file.mesh.tets.size(), tets) << name;
    return file;
  }
};

TEST_F(RealMesh, LiverOfGmsh1) {
  const MeshFile file = expect_counts("meshes/liver.msh", 181, 596);
  EXPECT_EQ(file.format, "Gmsh 1");
  EXPECT_TRUE(file.dropped.empty());
  EXPECT_EQ(file.mesh.points[0], (Vec3{-0.979259, 2.23512, 2.61245}));
  EXPECT_EQ(file.mesh.tets[0], (Tet{127, 140, 137, 141}));
}

TEST_F(RealMesh, LiverWithGapsInItsNodeNumbers) {
  const MeshFile file = expect_counts("meshes/liver2.msh", 507, 1493);
  const std::vector<std::pair<std::string, Index>> dropped{{"line", 71}, {"triangle", 860}};
  EXPECT_EQ(file.dropped, dropped);
  EXPECT_EQ(file.mesh.points[0], (Vec3{0.3708951229648599, -0.4656592203247305, -0.1604279814553062}));
}

TEST_F(RealMesh, RaptorsAndOssiclesOfVtk) {
  expect_counts("meshes/raptorTetra_8418.vtu", 2996, 8418);
  expect_counts("meshes/raptorTetra_19409.vtu", 5992, 19409);
  const MeshFile file = expect_counts("meshes/Ossicles.vtu", 1733, 5058);
  EXPECT_EQ(file.mesh.points[0], (Vec3{22.9337, 12.8615, 17.4548}));
}

TEST_F(RealMesh, HeadAndEyeOfMedit) {
  std::size_t points = 0;
  std::size_t tets = 0;
  for (const char* part : {"soft", "skull", "upper", "lower"}) {
    const MeshFile file = read_mesh(test::real_data_folder() / "reference/skull_headsq" /
                                    ("hq_" + std::string(part) + ".mesh"));
    points += file.mesh.points.size();
    tets += file.mesh.tets.size();
  }
  EXPECT_EQ(points, 7870U);
  EXPECT_EQ(tets, 23313U);
  points = tets = 0;
  for (const char* part : {"bulb", "fat", "muscle", "nerve", "skin", "skull"}) {
    const MeshFile file =
        read_mesh(test::real_data_folder() / "reference/eye_sdf" / (std::string(part) + ".mesh"));
    points += file.mesh.points.size();
    tets += file.mesh.tets.size();
  }
  EXPECT_EQ(points, 3382U);
  EXPECT_EQ(tets, 8787U);
}

}  // namespace
}  // namespace palpate::io

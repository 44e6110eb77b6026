#include <array>
#include <cmath>

#include <palpate/io/mesh_reader.hpp>

#include "mesh_program/meshed.hpp"

/// Where organs lie in the world, from each format.
namespace palpate::test {
namespace {

/// An ellipsoid with three different axes and off the middle, so that swapped axes or signs are noticed.
int ellipsoid(int i, int j, int k) {
  const double x = (i - 12) / 9.0;
  const double y = (j - 9) / 6.0;
  const double z = (k - 6) / 3.5;
  return x * x + y * y + z * z < 1.0 ? 1 : 0;
}

TestMap ellipsoid_map() {
  return {{30, 20, 12}, ellipsoid};
}

/// A rotation about (1, 2, 3) by 40 degrees and different steps along the axes.
TestMap oblique_map() {
  TestMap map = ellipsoid_map();
  map.steps = {{{0.5 * 0.782755554, 0.5 * 0.548798867, 0.5 * -0.293451096},
                {0.8 * -0.481954422, 0.8 * 0.832888888, 0.8 * 0.272058882},
                {2.0 * 0.393717763, 2.0 * -0.071525548, 2.0 * 0.916444444}}};
  map.origin = {-31.5, 14.25, 107.0};
  return map;
}

/// Expects each point of the mesh, back in voxels, at most half a voxel beyond the ellipsoid, its surface
/// points near it, and the middle of the mesh at the middle of the ellipsoid. `sign` is -1 if x and y are to
/// be negated (LPS to RAS).
void expect_ellipsoid(const TetMesh& mesh, const TestMap& map, double sign) {
  Vec3 mean{};
  double furthest = 0.0;
  const auto dot = [](const Vec3& a, const Vec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  for (const Vec3& p : mesh.points) {
    const Vec3 d{sign * p.x - map.origin.x, sign * p.y - map.origin.y, p.z - map.origin.z};
    std::array<double, 3> voxel{};
    for (std::size_t a = 0; a < 3; ++a) voxel[a] = dot(d, map.steps[a]) / dot(map.steps[a], map.steps[a]);
    const Vec3 e{(voxel[0] - 12) / 9.0, (voxel[1] - 9) / 6.0, (voxel[2] - 6) / 3.5};
    furthest = std::max(furthest, std::sqrt(dot(e, e)));
    const auto count = static_cast<double>(mesh.points.size());
    mean = {mean.x + voxel[0] / count, mean.y + voxel[1] / count, mean.z + voxel[2] / count};
  }
  EXPECT_NEAR(mean.x, 12.0, 0.5);
  EXPECT_NEAR(mean.y, 9.0, 0.5);
  EXPECT_NEAR(mean.z, 6.0, 0.5);
  EXPECT_NEAR(furthest, 1.0, 0.12);
}

TEST_F(MeshProgram, PlacesOfAnObliqueMapOfEachFormat) {
  const TestMap map = oblique_map();
  write("lps.nrrd", nrrd(map));
  write("ras.nrrd", nrrd(map, "right-anterior-superior"));
  write("map.nii", nifti(map));
  write("map.mha", meta_image(map));
  write_series("series", map, dicom_ct);
  struct Case {
    const char* file;
    const char* space;
    double sign;
  };
  for (const Case& c :
       {Case{"lps.nrrd", "lps", 1.0}, Case{"lps.nrrd", "ras", -1.0}, Case{"ras.nrrd", "ras", 1.0},
        Case{"ras.nrrd", "lps", -1.0}, Case{"map.nii", "ras", 1.0}, Case{"map.nii", "lps", -1.0},
        Case{"map.mha", "lps", 1.0}, Case{"series", "lps", 1.0}}) {
    SCOPED_TRACE(std::string(c.file) + " in " + c.space);
    const Json report = meshed(c.file, {"--size", "1", "--space", c.space});
    expect_volume(info("label-1"), map.volume(1));
    expect_ellipsoid(io::read_mesh(folder_ / "out/label-1.vtu").mesh, map, c.sign);
  }
}

TEST_F(MeshProgram, ALeftHandedMapGivesTetsOfPositiveVolume) {
  TestMap map = ellipsoid_map();
  map.steps = {{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1.5}}};
  map.origin = {40, -7, 3};
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.6"});
  TetMesh mesh = io::read_mesh(folder_ / "out/label-1.vtu").mesh;
  expect_ellipsoid(mesh, map, 1.0);
  EXPECT_EQ(check_mesh(mesh, "label-1").reoriented_tets, 0);
}

TEST_F(MeshProgram, AnisotropicVoxelsKeepTheVolume) {
  TestMap map({41, 41, 15}, [](int i, int j, int k) {
    const double x = 0.5 * (i - 20);
    const double y = 0.5 * (j - 20);
    const double z = 1.5 * (k - 7);
    return std::sqrt(x * x + y * y + z * z) < 8.0 ? 1 : 0;
  });
  map.steps = {{{0.5, 0, 0}, {0, 0.5, 0}, {0, 0, 1.5}}};
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.4"});
  expect_volume(info("label-1"), map.volume(1));
  expect_box(info("label-1"), {2, 2, 2.5}, {18, 18, 18.5}, 0.75);
}

TEST_F(MeshProgram, NamesAndColoursComeFromATable) {
  const TestMap map({30, 12, 12}, [](int i, int j, int k) {
    return j > 1 && j < 10 && k > 1 && k < 10 ? (i > 1 && i < 12 ? 1 : (i > 17 && i < 28 ? 5 : 0)) : 0;
  });
  write("map.nrrd", nrrd(map));
  write("slicer.ctbl",
        "# Color table file\n0 Background 0 0 0 0\n1 bone 241 214 145 255\n3 nerve 1 2 3 255\n5 fat 51 102 "
        "255 255\n");
  const Json slicer = meshed("map.nrrd", {"--size", "2", "--labels", "slicer.ctbl", "--rigid", "bone"});
  EXPECT_EQ(slicer["organs"][0]["name"], "bone");
  EXPECT_EQ(slicer["organs"][1]["name"], "fat");
  EXPECT_EQ(slicer["warnings"], Json::array({"no voxel has label 3 (nerve)"}));
  const Json scene = Json::parse(read("out/scene.json"));
  EXPECT_EQ(scene["bodies"][0]["obstacle"], true);
  EXPECT_FALSE(scene["bodies"][1].contains("obstacle"));
  EXPECT_NEAR(scene["bodies"][1]["color"][1].get<double>(), 0.4, 1e-12);

  write("snap.txt",
        "    0     0    0    0        0  0  0    \"Clear Label\"\n    5   255    0    0        1  1  1    "
        "\"eye fat\"\n");
  const Json snap = meshed("map.nrrd", {"--size", "2", "--labels", "snap.txt", "--only", "5"});
  ASSERT_EQ(snap["organs"].size(), 1U);
  EXPECT_EQ(snap["organs"][0]["name"], "eye fat");
}

}  // namespace
}  // namespace palpate::test

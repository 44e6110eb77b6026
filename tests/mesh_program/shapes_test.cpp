#include <cmath>
#include <fmt/format.h>
#include <regex>

#include "mesh_program/meshed.hpp"

/// Meshes of shapes whose volume, place and number of holes are known.
namespace palpate::test {
namespace {

double distance(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z);
}

TEST_F(MeshProgram, BallInAShell) {
  const TestMap map({33, 33, 33}, [](int i, int j, int k) {
    const double r = distance(i - 16, j - 16, k - 16);
    return r < 8.0 ? 3 : (r < 14.0 ? 7 : 0);
  });
  write("map.seg.nrrd", nrrd(map, "left-posterior-superior",
                             segment(0, 3, "the ball", "1 0.5 0") + segment(1, 7, "shell", "0 0 1")));
  const Json report = meshed("map.seg.nrrd", {"--size", "the ball=1.6", "--size", "2.2"});
  EXPECT_EQ(report["warnings"], Json::array());
  expect_volume(info("the-ball"), map.volume(3));
  expect_volume(info("shell"), map.volume(7));
  expect_box(info("the-ball"), {8, 8, 8}, {24, 24, 24}, 1.0);
  expect_box(info("shell"), {2, 2, 2}, {30, 30, 30}, 1.0);
  EXPECT_EQ(euler_characteristic("the-ball"), 2);
  EXPECT_EQ(euler_characteristic("shell"), 4);
  EXPECT_GT(report["organs"][0]["min_dihedral_angle"], 8.0);
  EXPECT_GT(report["organs"][1]["min_dihedral_angle"], 8.0);

  const Json scene = Json::parse(read("out/scene.json"));
  EXPECT_EQ(scene["bodies"][0]["name"], "the ball");
  EXPECT_EQ(scene["bodies"][0]["color"], Json::parse("[1.0, 0.5, 0.0]"));
  EXPECT_EQ(scene["bodies"][1]["name"], "shell");
  output_of({"run", "out/scene.json", "--steps", "2", "--no-picture", "--quiet"});
}

TEST_F(MeshProgram, TouchingBoxesTouchOrKeepTheirGap) {
  const TestMap map({34, 22, 22}, [](int i, int j, int k) {
    const bool in = i >= 5 && i < 29 && j >= 5 && j < 17 && k >= 5 && k < 17;
    return in ? (i < 17 ? 1 : 2) : 0;
  });
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.4"});
  expect_volume(info("label-1"), map.volume(1));
  expect_volume(info("label-2"), map.volume(2));
  expect_box(info("label-1"), {4.5, 4.5, 4.5}, {16.5, 16.5, 16.5}, 0.3);
  expect_box(info("label-2"), {16.5, 4.5, 4.5}, {28.5, 16.5, 16.5}, 0.3);

  (void)meshed("map.nrrd", {"--size", "1.4", "--gap", "1.5"});
  const double left = info("label-1")["upper"][0];
  const double right = info("label-2")["lower"][0];
  EXPECT_NEAR(right - left, 1.5, 0.3);
  EXPECT_NEAR(0.5 * (left + right), 16.5, 0.15);
  EXPECT_NEAR(info("label-1")["lower"][0].get<double>(), 4.5, 0.3) << "a face without a neighbour stays";
  EXPECT_EQ(json_of({"detect", "out/scene.json", "--format", "json"})["contacts"], Json::array());
}

TEST_F(MeshProgram, ThinShellIsWhole) {
  const TestMap map({41, 41, 41}, [](int i, int j, int k) {
    const double r = distance(i - 20, j - 20, k - 20);
    return 15.0 <= r && r < 17.0 ? 1 : 0;
  });
  write("map.nrrd", nrrd(map));
  EXPECT_EQ(meshed("map.nrrd", {"--size", "2"})["organs"][0]["parts"], 1);
  expect_volume(info("label-1"), map.volume(1));
  EXPECT_EQ(euler_characteristic("label-1"), 4);
}

TEST_F(MeshProgram, TorusKeepsItsHole) {
  const TestMap map({41, 41, 17}, [](int i, int j, int k) {
    return distance(distance(i - 20, j - 20, 0) - 13.0, k - 8, 0) < 5.0 ? 1 : 0;
  });
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.5"});
  expect_volume(info("label-1"), map.volume(1));
  EXPECT_EQ(euler_characteristic("label-1"), 0);
}

TEST_F(MeshProgram, PartsThatAreApartAreAllThere) {
  const TestMap map({60, 17, 17}, [](int i, int j, int k) {
    const auto in = [&](double x, double r) { return distance(i - x, j - 8, k - 8) < r; };
    return in(9, 7) || in(27, 5) || in(41, 4) || in(53, 2.5) ? 1 : 0;
  });
  write("map.nrrd", nrrd(map));
  const Json organ = meshed("map.nrrd", {"--size", "1.2"})["organs"][0];
  EXPECT_EQ(organ["parts"], 4);
  EXPECT_EQ(organ["warnings"], Json::array());
  expect_volume(info("label-1"), map.volume(1));
  EXPECT_EQ(euler_characteristic("label-1"), 8);
}

TEST_F(MeshProgram, APartBehindAThinNeckIsThereOrAWarningSaysSo) {
  const TestMap map({60, 17, 17}, [](int i, int j, int k) {
    const bool neck = i > 9 && i < 50 && std::abs(j - 8) < 2 && std::abs(k - 8) < 2;
    return neck || distance(i - 9, j - 8, k - 8) < 7 || distance(i - 50, j - 8, k - 8) < 7 ? 1 : 0;
  });
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.5"});
  expect_volume(info("label-1"), map.volume(1));
  expect_box(info("label-1"), {2, 1, 1}, {57, 15, 15}, 1.0);

  const Json coarse = meshed("map.nrrd", {"--size", "6"})["organs"][0];
  EXPECT_LT(info("label-1")["volume"].get<double>(), 0.95 * map.volume(1));
  EXPECT_NE(coarse["warnings"][0].get<std::string>().find("% of the volume"), std::string::npos);
}

TEST_F(MeshProgram, ALabelAtTheBorderOfTheMapEndsThere) {
  const TestMap map({14, 12, 10}, [](int, int, int) { return 1; });
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--size", "1.4"});
  expect_volume(info("label-1"), 14.0 * 12.0 * 10.0);
  expect_box(info("label-1"), {-0.5, -0.5, -0.5}, {13.5, 11.5, 9.5}, 0.3);
}

TEST_F(MeshProgram, SurfacesAreMeshedToo) {
  write("left.stl", box_stl({0, 0, 0}, {10, 20, 30}));
  write("right.stl", box_stl({10, 0, 0}, {25, 20, 30}));
  const Finished finished =
      palpate({"mesh", "left.stl", "right.stl", "--out", "out", "--size", "3", "--quiet"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  expect_volume(info("left"), 10.0 * 20.0 * 30.0);
  expect_volume(info("right"), 15.0 * 20.0 * 30.0);
  expect_box(info("right"), {10, 0, 0}, {25, 20, 30}, 0.3);
}

TEST_F(MeshProgram, ANumberOfTetsIsMet) {
  const TestMap map({40, 22, 22}, [](int i, int j, int k) {
    return distance(i - 11, j - 11, k - 11) < 9 ? 1 : (distance(i - 30, j - 11, k - 11) < 7 ? 2 : 0);
  });
  write("map.nrrd", nrrd(map));
  const auto tets = [](const Json& report, std::size_t organ) {
    return report["organs"][organ]["tets"].get<double>();
  };
  const Json together = meshed("map.nrrd", {"--tets", "4000"});
  EXPECT_NEAR(tets(together, 0) + tets(together, 1), 4000.0, 80.0);
  EXPECT_EQ(together["organs"][0]["size"], together["organs"][1]["size"]);
  const Json apart = meshed("map.nrrd", {"--tets", "1000", "--tets", "2=2000"});
  EXPECT_NEAR(tets(apart, 0), 1000.0, 50.0);
  EXPECT_NEAR(tets(apart, 1), 2000.0, 100.0);
}

TEST_F(MeshProgram, AThinSlabIsMeshed) {  // CGAL's exuder does not end on it by itself
  write("slab.off",
        "OFF\n8 12 0\n0 0 0\n0 0 2\n0 100 0\n0 100 2\n100 0 0\n100 0 2\n100 100 0\n100 100 2\n"
        "3 0 1 3\n3 0 3 2\n3 4 6 7\n3 4 7 5\n3 0 4 5\n3 0 5 1\n3 2 3 7\n3 2 7 6\n3 0 2 6\n3 0 6 4\n"
        "3 1 5 7\n3 1 7 3\n");
  const Json report = meshed("slab.off", {"--unit", "mm", "--tets", "3000"});
  EXPECT_GT(report["organs"][0]["min_dihedral_angle"], 8.0);
  EXPECT_NEAR(info("slab")["volume"].get<double>(), 20000.0, 1000.0);
  ASSERT_EQ(report["warnings"].size(), 1U) << "more tets than were asked for";
  EXPECT_EQ(report["warnings"][0],
            fmt::format("slab: {} tets, where 3000 were asked for: no size tried gives a nearer number",
                        report["organs"][0]["tets"].get<int>()));
}

TEST_F(MeshProgram, ASheetTooThinForItsTetsIsRefusedAndTheAdviceIsRight) {
  write("sheet.stl", box_stl({0, 0, 0}, {80, 80, 1}));
  const Finished refused =
      palpate({"mesh", "sheet.stl", "--unit", "mm", "--tets", "1000", "--out", "out", "--quiet"});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_FALSE(exists("out"));
  const std::regex words(
      "sheet: found no whole mesh of about 1000 tets, expected about (\\d+) tets or more "
      "where a shape is ([0-9.]+) mm thick");
  std::smatch said;
  ASSERT_TRUE(std::regex_search(refused.err, said, words)) << refused.err;
  EXPECT_NEAR(std::stod(said[2]), 0.976, 0.01) << "6400 mm^3, 13120 mm^2";
  const Json report = meshed("sheet.stl", {"--unit", "mm", "--size", "2"});
  const double advice = std::stod(said[1]);
  EXPECT_NEAR(report["organs"][0]["tets"].get<double>(), advice, 0.4 * advice) << "a size that is too large";
  EXPECT_NEAR(info("sheet")["volume"].get<double>(), 6400.0, 128.0);
}

TEST_F(MeshProgram, ASecondRunHasTheSameBits) {
  const TestMap map({24, 22, 20}, [](int i, int j, int k) {
    return distance(i - 11, 1.2 * (j - 10), k - 9.5) < 8.5 ? (i < 12 ? 1 : 2) : 0;
  });
  write("map.nrrd", nrrd(map));
  (void)meshed("map.nrrd", {"--tets", "2000", "--gap", "0.3"});
  const std::string first = read("out/label-1.vtu") + read("out/label-2.vtu") + read("out/scene.json");
  std::filesystem::remove_all(folder_ / "out");
  (void)meshed("map.nrrd", {"--tets", "2000", "--gap", "0.3"});
  EXPECT_TRUE(first == read("out/label-1.vtu") + read("out/label-2.vtu") + read("out/scene.json"));
}

}  // namespace
}  // namespace palpate::test

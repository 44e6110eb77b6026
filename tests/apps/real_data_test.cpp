#include "support/real_data.hpp"

#include "apps/workplace.hpp"

namespace palpate::test {
namespace {

std::filesystem::path meshes() {
  return std::filesystem::weakly_canonical(real_data_folder() / "meshes");
}

class RealData : public CommandTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::is_directory(meshes())) {
      GTEST_SKIP() << "no folder " << meshes() << ": set PALPATE_TEST_DATA to where the real meshes are";
    }
  }
  [[nodiscard]] Json info(const char* name) const { return json_of({"info", meshes() / name, "--json"}); }
  static void expect_counts(const Json& info, int points, int tets) {
    EXPECT_EQ(info["points"], points);
    EXPECT_EQ(info["tets"], tets);
    // Each edge of a closed surface lies in two triangles, so their number is even.
    EXPECT_EQ(info["triangles"].get<int>() % 2, 0);
    EXPECT_GT(info["volume"], 0.0);
  }
};

TEST_F(RealData, InfoOfOrgansAndAnimals) {
  const Json liver = info("liver.msh");
  expect_counts(liver, 181, 596);
  EXPECT_EQ(liver["format"], "Gmsh 1");
  // Euler: V - E + F = 2 on a sphere-like surface and V - E + F - T = 1 for the whole ball-like body, F = (4
  // T + S) / 2.
  const int tets = liver["tets"];
  const int faces = (4 * tets + liver["triangles"].get<int>()) / 2;
  EXPECT_EQ(liver["points"].get<int>() - liver["edges"].get<int>() + faces - tets, 1);
  expect_counts(info("Ossicles.vtu"), 1733, 5058);
  const Json coarse = info("raptorTetra_8418.vtu");
  expect_counts(coarse, 2996, 8418);
  EXPECT_EQ(coarse["unreferenced_points"], 3);
  const Json fine = info("raptorTetra_19409.vtu");
  expect_counts(fine, 5992, 19409);
  EXPECT_NEAR(coarse["volume"].get<double>() / fine["volume"].get<double>(), 1.0, 0.02) << "the same animal";
}

TEST_F(RealData, LiverDropsOnAPlateAndComesToRest) {
  // The mesh has no unit; at 3 cm each it is a liver of one litre, 19 cm wide.
  write("scene.json",
        R"({"name": "liver", "time_step": 0.01, "duration": 6, "contact": {"friction": 0.5}, "bodies": [
    {"name": "plate", "box": {"cells": [10, 10, 1], "size": [0.5, 0.5, 0.04]}, "translate": [0, 0, -0.02], "obstacle": true},
    {"name": "liver", "mesh": ")" +
            (meshes() / "liver.msh").string() + R"(", "scale": 0.03, "translate": [0.043, -0.081, 0.061],
     "material": {"young_modulus": 20000, "density": 1060, "mass_damping": 2, "stiffness_damping": 0.01}}]})");
  const Json report = json_of({"run", "scene.json", "--until-rest", "--json"});
  EXPECT_EQ(report["at_rest"], true);
  EXPECT_EQ(report["solver"]["steps_not_converged"], 0);
  const Json& liver = report["bodies"][1];
  EXPECT_NEAR(liver["mass"], 1060 * 36.5609 * 27e-6, 1e-3);
  EXPECT_NEAR(liver["contact_force"][2], liver["mass"].get<double>() * 9.81, 0.01 * 9.81)
      << "the plate carries it";
  EXPECT_LT(report["deepest"], 0.01) << "on the plate, not through it";
}

TEST_F(RealData, TwoRaptorsPressedTogetherComeToRest) {
  // 1.6 m long; each is held at its far side, and they overlap at the start.
  const std::string material =
      R"("material": {"young_modulus": 50000, "density": 1000, "mass_damping": 2, "stiffness_damping": 0.01})";
  write("scene.json",
        R"({"name": "raptors", "time_step": 0.01, "duration": 6, "gravity": [0, 0, 0], "bodies": [
    {"name": "left", "mesh": ")" +
            (meshes() / "raptorTetra_8418.vtu").string() + R"(", "scale": 0.1, )" + material + R"(,
     "fixed": [{"box": {"lower": [-1, -1, -1], "upper": [-0.05, 1, 1]}}]},
    {"name": "right", "mesh": ")" +
            (meshes() / "raptorTetra_19409.vtu").string() + R"(", "scale": 0.1,
     "translate": [0.3, 0, 0.05], )" +
            material + R"(, "fixed": [{"box": {"lower": [0.35, -1, -1], "upper": [1, 1, 1]}}]}]})");
  const Json report = json_of({"run", "scene.json", "--until-rest", "--json"});
  EXPECT_EQ(report["at_rest"], true);
  EXPECT_GT(report["contacts"]["last"], 0) << "they still touch";
  EXPECT_LT(report["deepest"], 0.005);
  const Json& left = report["bodies"][0]["contact_force"];
  const Json& right = report["bodies"][1]["contact_force"];
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(left[i].get<double>() + right[i].get<double>(), 0.0, 1e-9);
  EXPECT_LT(left[0], 0.0) << "the right one pushes the left one to the left";
}

}  // namespace
}  // namespace palpate::test

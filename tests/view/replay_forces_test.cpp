// Fields and forces of stored results. Oracle: the simulation of the run, and files written by hand.
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include <palpate/error.hpp>

#include "apps/workplace.hpp"
#include "geometry/vector.hpp"
#include "view/frame.hpp"
#include "view/messages.hpp"
#include "view/replay.hpp"
#include "view/scenes.hpp"

namespace palpate::test {
namespace {

class ReplayForces : public CommandTest {
 protected:
  void SetUp() override {
    write("scene.json", falling_box());
    output_of(
        {"run", "scene.json", "--out", "out", "--every", "5", "--no-picture", "--threads", "1", "--set",
         R"(output.fields=["von_mises", "stress", "contact_force", "reaction", "deformation_gradient"])"});
  }
  view::ReplaySource open() const { return view::ReplaySource(folder_ / "out", 1); }
};

Vec3 vector_of(const nlohmann::ordered_json& json) {
  return {json[0], json[1], json[2]};
}

TEST_F(ReplayForces, AreThoseOfTheRun) {
  view::ReplaySource source = open();
  const Scene scene = read_scene(folder_ / "scene.json");
  Simulation simulation(small_model(scene), scene.settings, 1);
  simulation.record_reactions(true);
  EXPECT_LT(length(vector_of(source.forces().at(1).at("force"))), 1e-300) << "nothing has acted at the start";
  double most = 0.0;
  for (int frame = 1; frame < 3; ++frame) {
    for (int step = 0; step < 5; ++step) {
      simulation.step();
      most = std::max(most, length(simulation.contact_forces()[1]));
    }
    source.advance();
    const nlohmann::ordered_json forces = source.forces();
    ASSERT_EQ(forces.size(), 2U);
    for (Index b = 0; b < 2; ++b) {
      const Wrench wrench = simulation.contact_wrench(b);
      const auto& told = forces.at(static_cast<std::size_t>(b));
      EXPECT_LT(length(vector_of(told.at("force")) - wrench.force), 1e-12 * (1.0 + length(wrench.force)));
      EXPECT_LT(length(vector_of(told.at("torque")) - wrench.torque), 1e-12 * (1.0 + length(wrench.torque)));
    }
    const Vec3 support = simulation.reaction_of_body(0, {}).force;
    EXPECT_LT(length(vector_of(forces[0].at("held").at("force")) - support), 1e-12 * length(support));
    EXPECT_FALSE(forces[1].contains("held")) << "the box is free";
  }
  const auto& history = source.stage().about["forces"];
  ASSERT_EQ(history["times"].size(), 11U) << "each step, not each frame";
  EXPECT_EQ(history["times"][7], 7 * 0.01);
  ASSERT_EQ(history["bodies"].size(), 2U);
  double largest = 0.0;
  for (const double force : history["bodies"][1]) largest = std::max(largest, force);
  EXPECT_NEAR(largest, most, 1e-12 * most);
  EXPECT_GT(most, 0.0);
}

TEST_F(ReplayForces, FieldsAreThoseOfTheFrames) {
  view::ReplaySource source = open();
  std::vector<std::string> names;
  for (const auto& field : source.stage().about["fields"]) names.push_back(field["name"]);
  EXPECT_EQ(names, (std::vector<std::string>{
                       "von_mises", "stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz",
                       "stress_xz", "contact_force", "reaction", "deformation_gradient_xx",
                       "deformation_gradient_xy", "deformation_gradient_xz", "deformation_gradient_yx",
                       "deformation_gradient_yy", "deformation_gradient_yz", "deformation_gradient_zx",
                       "deformation_gradient_zy", "deformation_gradient_zz"}))
      << "those that colours can show";
  const Scene scene = read_scene(folder_ / "scene.json");
  Simulation simulation(small_model(scene), scene.settings, 1);
  for (int step = 0; step < 10; ++step) simulation.step();
  source.apply(1, view::Seek{2});
  EXPECT_EQ(source.field("von_mises"), simulation.tissue_at_points().von_mises);
  const std::vector<Vec3> forces = simulation.tractions().point_forces;
  const std::vector<double> sizes = source.field("contact_force");
  ASSERT_EQ(sizes.size(), forces.size());
  double sum = 0.0;
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    EXPECT_NEAR(sizes[p], length(forces[p]), 1e-12 * (1.0 + sizes[p])) << p;
    sum += sizes[p];
  }
  EXPECT_GT(sum, 0.0);
  EXPECT_TRUE(source.field("stress").empty()) << "six numbers are no colour";
  const TissueState tissue = simulation.tissue_at_points();
  const std::vector<double> stress_zz = source.field("stress_zz");
  const std::vector<double> stress_yz = source.field("stress_yz");
  ASSERT_EQ(stress_yz.size(), tissue.stress.size());
  double sheared = 0.0;
  for (std::size_t p = 0; p < stress_yz.size(); ++p) {
    if (std::isnan(tissue.stress[p].yz)) continue;  // of a rigid body
    EXPECT_EQ(stress_zz[p], tissue.stress[p].zz) << p;
    EXPECT_EQ(stress_yz[p], tissue.stress[p].yz) << p;
    sheared = std::max(sheared, std::abs(stress_yz[p]));
  }
  EXPECT_GT(sheared, 0.0);
  const std::vector<double> zx = source.field("deformation_gradient_zx");
  ASSERT_EQ(zx.size(), tissue.size());
  for (std::size_t p = 0; p < zx.size(); ++p) EXPECT_EQ(zx[p], tissue.deformation_gradient[p][6]) << p;
  EXPECT_TRUE(source.field("pressure").empty()) << "the frames do not have it";
  EXPECT_TRUE(source.field("positions").empty());
  // Also in the message to a page.
  const view::Surface surface(source.bodies());
  const Read read =
      read_message(view::frame_message(source, surface, {.forces = true, .fields = {"von_mises"}}, {}));
  ASSERT_EQ(read.floats.at("von_mises").size(), surface.points().size());
  EXPECT_EQ(read.floats.at("von_mises")[3],
            static_cast<float>(at(simulation.tissue_at_points().von_mises, surface.points()[3])));
  EXPECT_EQ(read.header.at("forces").size(), 2U);
}

TEST_F(ReplayForces, AreAbsentWithoutTheirFile) {
  std::filesystem::remove(folder_ / "out/forces.csv");
  view::ReplaySource without = open();
  EXPECT_TRUE(without.forces().empty());
  EXPECT_FALSE(without.stage().about.contains("forces"));
  write("out/forces.csv", "step,time [s]\n0,0\n");
  EXPECT_TRUE(open().forces().empty()) << "of other bodies";
}

TEST(StoredForces, ReadsNamesInQuotesAndLeavesOutWhatIsCutOff) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "stored_forces_test.csv";
  std::string header = "step,time [s]";
  for (const char* end : {"force_x", "force_y", "force_z", "torque_x", "torque_y", "torque_z"})
    header += std::string(",\"the \"\"soft\"\", one contact ") + end + " [N]\"";
  std::ofstream(file) << header << "\n0,0,0,0,0,0,0,0\n1,0.5,1,2,2,4,5,6\n2,1,9,9,9\n";
  const std::vector<std::string> names{"the \"soft\", one"};
  const view::StoredForces forces(file, names);
  EXPECT_EQ(forces.at_time(0.5).at(0).at("force"), nlohmann::ordered_json({1.0, 2.0, 2.0}));
  EXPECT_EQ(forces.at_time(0.5).at(0).at("torque"), nlohmann::ordered_json({4.0, 5.0, 6.0}));
  EXPECT_TRUE(forces.at_time(1.0).empty());
  EXPECT_TRUE(forces.at_time(0.25).empty());
  EXPECT_EQ(forces.history()["bodies"][0], nlohmann::ordered_json({0.0, 3.0}));
  std::filesystem::remove(file);
}

/// A prescribed body has the force of its motor, also while no page moves it.
TEST(LiveForces, HaveTheMotorsOfPrescribedBodies) {
  const auto source = small_source();
  EXPECT_FALSE(source->forces().at(2).contains("held")) << "before the first step";
  for (int step = 0; step < 3; ++step) source->advance();
  const nlohmann::ordered_json forces = source->forces();
  const nlohmann::ordered_json& press = forces.at(2);
  const double weight = 9.81 * source->simulation().masses()[2];
  EXPECT_NEAR(press.at("held").at("force").at(2), weight, 1e-6 * weight) << "at constant speed";
  EXPECT_FALSE(forces.at(1).contains("held"));
}

}  // namespace
}  // namespace palpate::test

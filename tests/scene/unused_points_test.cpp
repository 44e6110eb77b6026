// Points of a mesh that are in no tet, as files of mesh programs have them. Oracle: the mesh without them.
#include <gtest/gtest.h>
#include <span>
#include <string>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/simulation.hpp>

#include "scene/error_check.hpp"
#include "scene/load.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

const TetMesh box = test::box_mesh({2, 2, 2}, {0, 0, 0}, {1, 1, 1});

/// The box with copies of the points of its upper face, and a point beside it.
TetMesh with_unused_points() {
  TetMesh mesh = box;
  for (const Vec3& p : box.points)
    if (p.z == 1.0) mesh.points.push_back(p);
  mesh.points.push_back({1.2, 1.2, 1.2});
  return mesh;
}

Model model_of(const std::string& body, bool unused) {
  const Scene scene = read_scene_text(R"({"bodies": [
    {"name": "box", "mesh": "box.vtu", "material": {}, )" +
                                          body + R"(},
    {"name": "roof", "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "translate": [0.5, 0.5, 1.5], "material": {}}]})",
                                      "s.json", "/base");
  return load_model(scene, [&](const std::filesystem::path&) { return unused ? with_unused_points() : box; });
}

TEST(UnusedPoints, AreNotSelected) {
  for (const char* points : {R"("box": {"lower": [0, 0, 1], "upper": [1, 1, 1]})",
                             R"("sphere": {"center": [1, 1, 1], "radius": 0.1})",
                             R"("near": {"body": "roof", "distance": 0.01})"}) {
    const std::string load = std::string(R"("loads": [{)") + points + R"(, "force": [0, 0, 1]}])";
    const std::string tie = std::string(R"("attached": [{)") + points + R"(, "to": "roof"}])";
    const auto expected = model_of(load, false).point_loads[0].points;
    EXPECT_FALSE(expected.empty());
    EXPECT_EQ(model_of(load, true).point_loads[0].points, expected) << points;
    EXPECT_EQ(model_of(tie, true).ties.size(), expected.size()) << points;
  }
}

TEST(UnusedPoints, AreNotGrabbed) {
  const std::string grab = R"("grabs": [{"from": [1.2, 1.2, 1.2], "target": [1, 1, 2], "stiffness": 10}])";
  const Index point = model_of(grab, false).grabs[0].point;
  EXPECT_EQ(model_of(grab, true).grabs[0].point, point);
}

TEST(UnusedPoints, ByTheirIndexAreAnError) {
  const auto unused = std::to_string(box.points.size());
  for (const std::string& part : {R"("fixed": [{"points": [0, )" + unused + "]}]",
                                  R"("loads": [{"points": [0, )" + unused + R"(], "force": [0, 0, 1]}])"}) {
    const std::string message = message_of([&] { model_of(part, true); });
    EXPECT_NE(message.find(".points[1]: found " + unused + ", a point in no tet"), std::string::npos)
        << message;
  }
}

TEST(UnusedPoints, TakeNoForcesOfAModel) {
  const auto unused = static_cast<Index>(box.points.size());
  const auto message = [&](auto&& act) {
    Model model = model_of(R"("fixed": [{"points": [0]}])", true);
    return message_of([&] { act(model); });
  };
  const std::string of_load = message([&](Model& model) {
    model.point_loads.push_back({{unused}, {0, 0, 1}, {}});
    Simulation simulation(std::move(model), {}, 1);
  });
  const std::string of_tie = message([&](Model& model) {
    model.ties.push_back(
        {unused, std::ssize(model.bodies.tets()) > 0 ? static_cast<Index>(model.bodies.tets().size() - 1) : 0,
         1.0});
    Simulation simulation(std::move(model), {}, 1);
  });
  const std::string of_grab = message([&](Model& model) {
    Simulation simulation(std::move(model), {}, 1);
    simulation.grab({unused, {0, 0, 1}, 1.0});
  });
  const std::string of_model_grab = message([&](Model& model) {
    model.grabs.push_back({unused, {0, 0, 1}, 1.0});
    Simulation simulation(std::move(model), {}, 1);
  });
  for (const std::string& text : {of_load, of_tie, of_grab, of_model_grab})
    EXPECT_NE(text.find("which is in no tet"), std::string::npos) << text;
}

// One of them is inside another body. Four corners of the upper box are, too, and one point of the lower one.
TEST(UnusedPoints, HaveNoContactsInAnyStructure) {
  Bodies bodies;
  bodies.add("lower", box);
  TetMesh mesh = test::box_mesh({1, 1, 1}, {0.2, 0.2, 0.9}, {0.8, 0.8, 1.9});
  mesh.points.push_back({0.5, 0.5, 0.5});
  bodies.add("upper", std::move(mesh));
  for (const Structure structure :
       {Structure::compact, Structure::uniform, Structure::hash, Structure::cuckoo, Structure::brute}) {
    DetectionSettings settings;
    settings.structure = structure;
    Detector detector(bodies, settings, {}, 1);
    detector.detect(bodies.points_rest());
    EXPECT_EQ(detector.contacts().size(), 5U) << at(structure_names, static_cast<int>(structure));
  }
}

}  // namespace
}  // namespace palpate

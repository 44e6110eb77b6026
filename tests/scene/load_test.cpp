#include "scene/load.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <string>

#include "geometry/vector.hpp"
#include "scene/error_check.hpp"

namespace palpate {
namespace {

void expect_near(const Vec3& a, const Vec3& b) {
  EXPECT_LT(length(a - b), 1e-14) << a.x << " " << a.y << " " << a.z;
}

Scene scene_of(const std::string& body) {
  return read_scene_text(R"({"bodies": [{"material": {}, )" + body + "}]}", "s.json", "/base");
}

Index fixed_count(const std::string& body) {
  const auto fixed = load_model(scene_of(body), {}).fixed_points;
  return std::accumulate(fixed.begin(), fixed.end(), Index{0});
}

std::string load_problem(const std::string& body) {
  return message_of([&] { load_model(scene_of(body), {}); });
}

const std::string box = R"("box": {"cells": [2, 2, 2], "size": [2, 2, 2]})";

TEST(Transformed, ScalesThenRotatesThenTranslates) {
  const Transform transform{.scale = {2, 3, 4}, .rotate = {{0, 0, 5}, 90, {}}, .translate = {10, 20, 30}};
  expect_near(transformed(transform, {1, 1, 1}), {10 - 3, 20 + 2, 30 + 4});
}

TEST(Transformed, TurnsRightHandedAboutAnyAxis) {
  expect_near(transformed({.rotate = {{1, 0, 0}, 90, {}}}, {0, 1, 0}), {0, 0, 1});
  expect_near(transformed({.rotate = {{1, 1, 1}, 120, {}}}, {1, 2, 3}), {3, 1, 2});
  expect_near(transformed({.rotate = {{0, 1, 0}, -90, {}}}, {0, 0, 1}), {-1, 0, 0});
}

TEST(Transformed, TakesAQuaternionOfAnyLengthForTheSameTurn) {
  const double half = 0.5 * 0.7;
  const Vec3 axis = normalized({1, -2, 3});
  const double s = 5.0 * std::sin(half);
  const Rotation quaternion{.quaternion = {{5.0 * std::cos(half), s * axis.x, s * axis.y, s * axis.z}}};
  const Rotation axis_angle{{2, -4, 6}, 0.7 * 180.0 / std::acos(-1.0), {}};
  for (const Vec3& p : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{-0.3, 0.2, 0.9}}) {
    expect_near(transformed({.rotate = quaternion}, p), transformed({.rotate = axis_angle}, p));
  }
}

TEST(Transformed, LeavesPointsBitForBitWithoutATurn) {
  const Vec3 p{0.1, -1.0 / 3.0, 1e-17};
  EXPECT_EQ(transformed({}, p), p);
}

TEST(LoadBodies, PlacesBodiesInOrderWithTheirMaterials) {
  const Scene scene = read_scene_text(R"({"bodies": [
      {"name": "floor", "obstacle": true, "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}},
      {"name": "ball", "material": {"density": 7}, "ball": {"radius": 1, "resolution": 1}, "translate": [0, 0, 5]}]})",
                                      "s.json");
  const auto loaded = load_model(scene, {});
  ASSERT_EQ(loaded.bodies.body_count(), 2);
  EXPECT_EQ(loaded.bodies.bodies()[0].name, "floor");
  EXPECT_EQ(loaded.bodies.bodies()[1].name, "ball");
  EXPECT_EQ(loaded.obstacles, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(loaded.materials[1].density, 7.0);
  EXPECT_EQ(loaded.materials[1].young_modulus, Material{}.young_modulus);
  std::vector<std::uint8_t> expected(8 + 13, 0);
  std::fill_n(expected.begin(), 8, std::uint8_t{1});
  EXPECT_EQ(loaded.fixed_points, expected);
  EXPECT_EQ(loaded.bodies.points_rest()[8], (Vec3{0, 0, 5}));
}

TEST(LoadBodies, ReadsMeshesRelativeToTheScene) {
  std::vector<std::string> asked;
  const MeshReader reader = [&](const std::filesystem::path& path) {
    asked.push_back(path.string());
    return TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  };
  const auto loaded = load_model(scene_of(R"("mesh": "data/a.vtu", "scale": 2)"), reader);
  load_model(scene_of(R"("mesh": "/abs/b.vtu")"), reader);
  EXPECT_EQ(asked, (std::vector<std::string>{"/base/data/a.vtu", "/abs/b.vtu"}));
  EXPECT_EQ(loaded.bodies.points_rest()[1], (Vec3{2, 0, 0}));
}

/// Labels are in the mesh file: read once for a body, and only where a region asks for one.
TEST(LoadRegions, ALabelOfTheMeshFileSelectsTets) {
  const MeshReader reader = [](const std::filesystem::path&) {
    return TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {2, 1, 1}},
                   {{0, 1, 2, 3}, {1, 2, 3, 4}, {1, 2, 4, 5}}};
  };
  std::vector<std::string> asked;
  const CellReader labels = [&](const std::filesystem::path& path, const std::string& name,
                                std::size_t components) {
    asked.push_back(path.string() + ":" + name + ":" + std::to_string(components));
    return std::vector<double>{7, 2, 7};
  };
  const auto of = [&](const std::string& regions) {
    return load_model(scene_of(R"("mesh": "a.vtu", "regions": [)" + regions + "]"), reader, labels);
  };
  const Model model =
      of(R"({"label": 7, "material": {"density": 5}}, {"label": 2, "material": {"density": 6}})");
  EXPECT_EQ(model.material_of_tet, (std::vector<Index>{1, 2, 1}));
  EXPECT_EQ(model.materials[1].density, 5.0);
  EXPECT_EQ(asked, (std::vector<std::string>{"/base/a.vtu:label:1"}));
  of(R"({"tets": [0], "material": {}})");
  EXPECT_EQ(asked.size(), 1U);
  EXPECT_EQ(message_of([&] { of(R"({"label": 3, "material": {}})"); }),
            "s.json: bodies[0].regions[0].label: found 3, expected a label of its tets: 2, 7");
  EXPECT_EQ(
      message_of([&] {
        load_model(scene_of(box + R"(, "regions": [{"label": 3, "material": {}}])"), reader, labels);
      }),
      "s.json: bodies[0].regions[0].label: found this key in a body without a mesh file, expected a body "
      "with 'mesh'");
}

/// Two tets, one in a region without a field; rotated and scaled with the body.
TEST(LoadFibres, AFieldOfTheMeshFileIsPlacedWithItsBody) {
  const MeshReader reader = [](const std::filesystem::path&) {
    return TetMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}}, {{0, 1, 2, 3}, {1, 2, 3, 4}}};
  };
  std::vector<std::string> asked;
  std::size_t count = 2;
  const CellReader vectors = [&](const std::filesystem::path& path, const std::string& name, std::size_t) {
    asked.push_back(path.string() + ":" + name);
    std::vector<double> data;
    for (std::size_t i = 0; i < count; ++i) data.insert(data.end(), {1, 2, 0});
    return data;
  };
  const auto text = [](const std::string& more) {
    return R"({"bodies": [{"ball": {"radius": 1, "resolution": 1}, "material": {}, "translate": [9, 9, 9]}, {
      "mesh": "a.vtu", "scale": [1, 2, 1], "rotate": {"axis": [0, 0, 1], "angle": 90},
      "translate": [5, 5, 5], "material": {"model": "mooney-rivlin", "fibres": {"stiffness": 1, "field": "way"}})" +
           more + "}]}";
  };
  const Scene scene = read_scene_text(text(""), "s.json", "/base");
  const Model model = load_model(scene, reader, vectors);
  const auto first = static_cast<std::size_t>(model.bodies.bodies()[1].tets.begin);
  ASSERT_EQ(model.fibre_of_tet.size(), first + 2);
  EXPECT_EQ(model.fibre_of_tet[0], Vec3{});
  expect_near(model.fibre_of_tet[first], {-4, 1, 0});
  EXPECT_EQ(asked, (std::vector<std::string>{"/base/a.vtu:way"}));
  const std::string region =
      R"(, "regions": [{"tets": [1], "material": {"model": "mooney-rivlin", "fibres": {"stiffness": 1}}}])";
  const Model parts = load_model(read_scene_text(text(region), "s.json"), reader, vectors);
  expect_near(parts.fibre_of_tet[first], {-4, 1, 0});
  EXPECT_EQ(parts.fibre_of_tet[first + 1], Vec3{});
  count = 3;
  EXPECT_EQ(message_of([&] { load_model(scene, reader, vectors); }),
            "s.json: bodies[1].material.fibres.field: found 3 vectors, expected 2, one a tet");
  EXPECT_EQ(
      message_of([&] {
        load_model(scene_of(box + R"(, "regions": [{"tets": [0], "material":
                {"model": "mooney-rivlin", "fibres": {"stiffness": 1, "field": "way"}}}])"),
                   reader, vectors);
      }),
      "s.json: bodies[0].regions[0].material.fibres.field: found this key in a body without a mesh file, "
      "expected a body with 'mesh'");
}

/// A box of four cells along x.
Scene bar(const std::string& ends, const std::string& fibres = R"({"stiffness": 1})") {
  return read_scene_text(
      R"({"bodies": [{"box": {"cells": [4, 1, 1], "size": [4, 1, 1]}, "material": {"model": "mooney-rivlin", "fibres": )" +
          fibres + R"(}, "fibre_ends": )" + ends + "}]}",
      "s.json");
}
std::string end_at(double x) {
  return R"([{"box": {"lower": [)" + std::to_string(x - 0.1) + R"(, -9, -9], "upper": [)" +
         std::to_string(x + 0.1) + R"(, 9, 9]}}])";
}

TEST(LoadFibres, RunBetweenTheEndsOfABody) {
  const auto ends = [](double from, double to) {
    return R"({"from": )" + end_at(from) + R"(, "to": )" + end_at(to) + "}";
  };
  const auto problem = [](const std::string& key, const std::string& fibres = R"({"stiffness": 1})") {
    return message_of([&] { load_model(bar(key, fibres), {}); });
  };
  const Model model = load_model(bar(ends(-2, 2)), {});
  ASSERT_EQ(model.fibre_of_tet.size(), model.bodies.tets().size());
  for (const Vec3& fibre : model.fibre_of_tet) EXPECT_LT(length(fibre - Vec3{1, 0, 0}), 1e-12);
  EXPECT_EQ(
      problem(ends(-2, 9)),
      "s.json: bodies[0].fibre_ends.to[0]: found no point of 'body 0', expected one or more points selected");
  EXPECT_EQ(problem(R"({"from": [{"points": [3]}], "to": [{"points": [2, 3]}]})"),
            "s.json: bodies[0].fibre_ends.to: found point 3, which is in 'from' too, expected ends without a "
            "common point");
  EXPECT_EQ(problem(R"({"from": [], "to": []})"),
            "s.json: bodies[0].fibre_ends.from: found none, expected one or more");
  EXPECT_EQ(problem(ends(-2, 2), R"({"stiffness": 1, "field": "way"})"),
            "s.json: bodies[0].fibre_ends: found 'fibre_ends' together with 'fibres.field', expected only "
            "one of the two");
  EXPECT_EQ(problem(ends(-2, 2), "{}"),
            "s.json: bodies[0].fibre_ends: found 'fibre_ends' in a body without fibres, expected 'fibres' in "
            "its material "
            "or that of a region");
}

TEST(LoadBodies, SelectsInWorldCoordinatesWithTheBoundary) {
  EXPECT_EQ(fixed_count(box + R"(, "fixed": [{"box": {"lower": [-1, -1, 1], "upper": [1, 1, 1]}}])"), 9);
  EXPECT_EQ(fixed_count(box + R"(, "fixed": [{"sphere": {"center": [0, 0, 0], "radius": 1}}])"), 7);
  EXPECT_EQ(fixed_count(box + R"(, "translate": [5, 0, 0],
                               "fixed": [{"box": {"lower": [5.5, -9, -9], "upper": [9, 9, 9]}}])"),
            9);
  EXPECT_EQ(fixed_count(box + R"(, "fixed": [{"points": [0, 26]}])"), 2);
}

TEST(LoadBodies, AddsSelectionsUp) {
  const auto fixed = load_model(scene_of(box + R"(, "fixed": [
      {"points": [3, 1]}, {"sphere": {"center": [-1, -1, -1], "radius": 0.1}}, {"points": [3]}])"),
                                {})
                         .fixed_points;
  std::vector<std::uint8_t> expected(27, 0);
  expected[0] = expected[1] = expected[3] = 1;
  EXPECT_EQ(fixed, expected);
}

TEST(LoadBodies, RefusesSelectionsOfNothing) {
  EXPECT_EQ(
      load_problem(box + R"(, "fixed": [{"points": [1]}, {"sphere": {"center": [9, 0, 0], "radius": 1}}])"),
      "s.json: bodies[0].fixed[1]: found no point of 'body 0', expected one or more points selected");
  EXPECT_EQ(load_problem(box + R"(, "fixed": [{"points": [1, 27]}])"),
            "s.json: bodies[0].fixed[0].points[1]: found 27, expected a point index in [0, 26]");
}

TEST(LoadBodies, GivesTheTetsOfRegionsTheirMaterials) {
  // Cells of 1 m, 5 tets each, from x = 4 on; the second cell's centres are at x > 5.
  const std::string bar = R"("box": {"cells": [2, 1, 1], "size": [2, 1, 1]}, "translate": [5, 0, 0])";
  const auto loaded = load_model(read_scene_text(R"({"bodies": [
      {"name": "floor", "obstacle": true, "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}},
      {"name": "bar", "material": {"density": 1}, )" +
                                                     bar +
                                                     R"(, "regions": [
        {"box": {"lower": [5, -9, -9], "upper": [9, 9, 9]}, "material": {"density": 2}},
        {"sphere": {"center": [5.5, 0, 0], "radius": 1e-9}, "material": {"density": 3}},
        {"tets": [0, 7], "material": {"density": 4}}]},
      {"name": "last", "material": {"density": 5}, "ball": {"radius": 1, "resolution": 1}}]})",
                                                 "s.json"),
                                 {});
  std::vector<double> densities;
  ASSERT_EQ(loaded.material_of_tet.size(), 5U + 10U + 20U);
  for (const Index m : loaded.material_of_tet) densities.push_back(at(loaded.materials, m).density);
  std::vector<double> expected(35, 5.0);
  std::fill_n(expected.begin(), 5, 1000.0);
  std::fill_n(expected.begin() + 5, 5, 1.0);
  std::fill_n(expected.begin() + 10, 5, 2.0);
  // The tet in the middle of a cell is the one whose centre is the cell's.
  Index middle = -1;
  for (Index t = 10; t < 15; ++t) {
    Vec3 center;
    for (const Index p : at(loaded.bodies.tets(), t)) center += 0.25 * at(loaded.bodies.points_rest(), p);
    if (length(center - Vec3{5.5, 0, 0}) < 1e-9) middle = t;
  }
  ASSERT_GE(middle, 0);
  at(expected, middle) = 3.0;
  expected[5] = expected[12] = 4.0;
  EXPECT_EQ(densities, expected);
  EXPECT_TRUE(load_model(scene_of(box), {}).material_of_tet.empty());
}

TEST(LoadBodies, RefusesRegionsOfNothing) {
  EXPECT_EQ(load_problem(box + R"(, "regions": [{"tets": [40], "material": {}}])"),
            "s.json: bodies[0].regions[0].tets[0]: found 40, expected a tet index in [0, 39]");
  EXPECT_EQ(load_problem(box + R"(, "regions": [{"tets": [39], "material": {}},
                         {"sphere": {"center": [9, 0, 0], "radius": 1}, "material": {}}])"),
            "s.json: bodies[0].regions[1]: found no tet of 'body 0', expected one or more tets selected");
}

TEST(LoadBodies, PassesMeshErrorsOn) {
  const MeshReader broken = [](const std::filesystem::path& path) -> TetMesh {
    throw Error(path.string(), "line 3", "nothing", "a point");
  };
  EXPECT_EQ(message_of([&] { load_model(scene_of(R"("mesh": "a.vtu")"), broken); }),
            "s.json: bodies[0].mesh, /base/a.vtu, line 3: found nothing, expected a point");
  const std::string huge = R"("box": {"cells": [1, 1, 1], "size": [1e100, 1, 1]}, "scale": 1e3)";
  EXPECT_TRUE(load_problem(huge).starts_with("s.json: bodies[0] 'body 0', point 0: found"))
      << load_problem(huge);
}

constexpr const char* jaw_and_tissue = R"({"bodies": [
    {"name": "jaw", "box": {"cells": [1, 1, 1], "size": [2, 2, 2]}, "motion": {
        "center": [0, 0, 5], "interpolation": "smooth",
        "keyframes": [{"time": 0}, {"time": 2, "translate": [1, 0, 0], "rotate": {"axis": [0, 0, 2], "angle": 180}}]}},
    {"name": "tissue", "material": {}, "box": {"cells": [2, 2, 2], "size": [2, 2, 2]}, "translate": [10, 0, 0],
     "attached": [{"to": "jaw", "box": {"lower": [9, -1, -1], "upper": [9, 1, 1]}}],
     "loads": [{"force": [0, 0, 18], "box": {"lower": [11, -1, -1], "upper": [11, 1, 1]}},
               {"force": [1, 0, 0], "points": [26]}],
     "grabs": [{"from": [11.1, 1.2, 0.9], "target": [20, 0, 0], "stiffness": 7}]}]})";

TEST(LoadModel, PutsMotionsAttachmentsLoadsAndGrabsOnTheirPoints) {
  const Model model = load_model(read_scene_text(jaw_and_tissue, "s.json"), {});
  EXPECT_EQ(model.obstacles, (std::vector<std::uint8_t>{1, 0}));
  ASSERT_EQ(model.motions.size(), 1U);
  EXPECT_EQ(model.motions[0].center, (Vec3{0, 0, 5}));
  EXPECT_EQ(model.motions[0].interpolation, Interpolation::smooth);
  ASSERT_EQ(model.motions[0].keyframes.size(), 2U);
  EXPECT_EQ(model.motions[0].keyframes[1].time, 2.0);
  EXPECT_EQ(model.motions[0].keyframes[1].translate, (Vec3{1, 0, 0}));
  EXPECT_NEAR(model.motions[0].keyframes[1].quaternion[0], 0.0, 1e-15);
  EXPECT_NEAR(model.motions[0].keyframes[1].quaternion[3], 1.0, 1e-15);
  const auto points = model.bodies.points_rest();
  ASSERT_EQ(points.size(), 8U + 27U);
  for (std::size_t p = 0; p < points.size(); ++p) {
    EXPECT_EQ(model.fixed_points[p], p < 8 ? 1 : 0);
    EXPECT_EQ(model.motion_of_point[p], p < 8 || points[p].x == 9.0 ? 0 : -1);
  }
  EXPECT_TRUE(model.forces.empty()) << "those of set_forces(), which adds to the loads of a scene";
  ASSERT_EQ(model.point_loads.size(), 2U);
  EXPECT_EQ(model.point_loads[0].force, (Vec3{0, 0, 18}));
  EXPECT_EQ(model.point_loads[0].points.size(), 9U);
  for (const Index p : model.point_loads[0].points) EXPECT_EQ(points[static_cast<std::size_t>(p)].x, 11.0);
  EXPECT_EQ(model.point_loads[1].force, (Vec3{1, 0, 0}));
  EXPECT_EQ(model.point_loads[1].points, std::vector<Index>{8 + 26});
  ASSERT_EQ(model.grabs.size(), 1U);
  EXPECT_EQ(points[static_cast<std::size_t>(model.grabs[0].point)], (Vec3{11, 1, 1}));
  EXPECT_EQ(model.grabs[0].stiffness, 7.0);
}

TEST(LoadModel, PutsSurfaceLoadsRampsGravityAndTurnsOnABody) {
  const std::string loads =
      box + R"(, "translate": [5, 0, 0], "velocity": [1, 0, 0], "angular_velocity": [0, 0, 2],
      "gravity": [0, 0, -1], "loads": [
        {"force": [0, 0, 8], "points": [0, 1]},
        {"force": [4, 0, 0], "points": [2], "ramp": {"times": [0, 1], "factors": [0, 2]}},
        {"pressure": 7, "box": {"lower": [4, -1, 1], "upper": [6, 1, 1]}},
        {"traction": [0, 3, 0], "box": {"lower": [4, -1, -1], "upper": [4, 1, 1]}, "ramp": {"times": [3], "factors": [1]}}])";
  const Model model = load_model(scene_of(loads), {});
  ASSERT_EQ(model.point_loads.size(), 2U);
  EXPECT_EQ(model.point_loads[0].points, (std::vector<Index>{0, 1}));
  EXPECT_TRUE(model.point_loads[0].ramp.times.empty());
  EXPECT_EQ(model.point_loads[1].points, std::vector<Index>{2});
  EXPECT_EQ(model.point_loads[1].ramp.factors, (std::vector<double>{0.0, 2.0}));
  ASSERT_EQ(model.surface_loads.size(), 2U);
  EXPECT_EQ(model.surface_loads[0].pressure, 7.0);
  EXPECT_EQ(model.surface_loads[0].triangles.size(), 8U) << "the top of 2 x 2 cells";
  for (const Index t : model.surface_loads[0].triangles) {
    for (const Index p : at(model.bodies.triangles(), t)) EXPECT_EQ(at(model.bodies.points_rest(), p).z, 1.0);
  }
  EXPECT_EQ(model.surface_loads[1].traction, (Vec3{0, 3, 0}));
  EXPECT_EQ(model.surface_loads[1].ramp.times, std::vector<double>{3.0});
  ASSERT_EQ(model.gravity_of_body.size(), 1U);
  EXPECT_EQ(model.gravity_of_body[0], (Vec3{0, 0, -1}));
  for (std::size_t p = 0; p < model.velocities.size(); ++p) {
    const Vec3 arm = model.bodies.points_rest()[p] - Vec3{5, 0, 0};
    expect_near(model.velocities[p], Vec3{1, 0, 0} + cross({0, 0, 2}, arm));
  }
  EXPECT_EQ(
      load_problem(box + R"(, "loads": [{"pressure": 1, "points": [0]}])"),
      "s.json: bodies[0].loads[0]: found no surface triangle with all of its corners, expected one or more "
      "triangles selected");
}

TEST(LoadModel, GivesRigidBodiesTheDensityOfWaterInTheUnitsOfTheScene) {
  const Scene scene = read_scene_text(
      R"({"units": {"length": "mm", "mass": "g"}, "bodies": [{"obstacle": true, )" + box + "}]}", "s.json");
  EXPECT_DOUBLE_EQ(load_model(scene, {}).materials[0].density, 1e-3);
}

TEST(LoadModel, RefusesAttachmentsThatCannotBe) {
  const auto attached = [](const std::string& list) {
    return message_of([&] {
      load_model(read_scene_text(R"({"bodies": [
          {"name": "jaw", "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "motion": {"keyframes": [{"time": 0}]}},
          {"name": "skull", "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "motion": {"keyframes": [{"time": 0}]}},
          {"name": "tissue", "material": {}, "box": {"cells": [1, 1, 1], "size": [1, 1, 1]}, "attached": )" +
                                     list + R"(},
          {"name": "away", "box": {"cells": [1, 1, 1], "size": [1, 1, 1]},
           "motion": {"keyframes": [{"time": 0, "translate": [0, 0, 1]}]}}]})",
                                 "s.json"),
                 {});
    });
  };
  EXPECT_EQ(attached(R"([{"to": "jav", "points": [0]}])"),
            "s.json: bodies[2].attached[0].to: found 'jav', expected another body: 'jaw'");
  EXPECT_EQ(
      attached(R"([{"to": "jaw", "points": [0]}, {"to": "skull", "points": [1, 0]}])"),
      "s.json: bodies[2].attached[1]: found point 0, which is attached to another body too, expected points "
      "that follow one body");
  EXPECT_EQ(attached(R"([{"to": "jaw", "points": [3]}], "fixed": [{"points": [3]}])"),
            "s.json: bodies[2].attached[0]: found point 3, which is fixed, expected points that are not in "
            "'fixed' too");
  EXPECT_EQ(
      attached(R"([{"to": "away", "points": [0]}])"),
      "s.json: bodies[2].attached[0].to: found 'away', whose first keyframe is away from its placement, "
      "expected a body whose motion starts where the body is placed");
  EXPECT_EQ(attached(R"([{"to": "jaw", "points": [8]}])"),
            "s.json: bodies[2].attached[0].points[0]: found 8, expected a point index in [0, 7]");
}

/// A block of 2 x 2 x 2 that hangs 0.5 above another, wider one.
std::string above(const std::string& lower, const std::string& upper) {
  return R"({"bodies": [{"name": "lower", "box": {"cells": [4, 4, 1], "size": [4, 4, 1]}, )" + lower +
         R"(}, {"name": "upper", "box": {"cells": [2, 2, 2], "size": [2, 2, 2]}, "translate": [0, 0, 2],
            "material": {}, )" +
         upper + "}]}";
}

TEST(LoadModel, SelectsPointsNearAnotherBody) {
  const std::string soft = R"("material": {})";
  const auto fixed_of = [&](const std::string& near) {
    const Model model =
        load_model(read_scene_text(above(soft, R"("fixed": [{"near": )" + near + "}]"), "s.json"), {});
    std::vector<Vec3> fixed;
    for (std::size_t p = 0; p < model.fixed_points.size(); ++p) {
      if (model.fixed_points[p] != 0) fixed.push_back(model.bodies.points_rest()[p]);
    }
    return fixed;
  };
  const auto lowest = fixed_of(R"({"body": "lower", "distance": 0.51})");
  EXPECT_EQ(lowest.size(), 9U);
  for (const Vec3& p : lowest) EXPECT_EQ(p.z, 1.0);
  EXPECT_EQ(fixed_of(R"({"body": "lower", "distance": 1.51})").size(), 18U);
  const auto some =
      fixed_of(R"({"body": "lower", "distance": 1.51, "box": {"lower": [0.5, -9, -9], "upper": [9, 9, 9]}})");
  EXPECT_EQ(some.size(), 6U);
  for (const Vec3& p : some) EXPECT_EQ(p.x, 1.0);
  const auto message = [&](const std::string& near) { return message_of([&] { fixed_of(near); }); };
  EXPECT_EQ(message(R"({"body": "lover", "distance": 1})"),
            "s.json: bodies[1].fixed[0].near.body: found 'lover', expected another body: 'lower'");
  EXPECT_EQ(message(R"({"body": "lower", "distance": 0.49})"),
            "s.json: bodies[1].fixed[0]: found no point of 'upper', expected one or more points selected");
  EXPECT_EQ(message(R"({"body": "lower"})"),
            "s.json: bodies[1].fixed[0].near.distance: found nothing, expected a value");
}

TEST(LoadModel, AttachesToWhatDeformsByTies) {
  const std::string near = R"("near": {"body": "lower", "distance": 0.51})";
  const auto model_of = [&](const std::string& lower, const std::string& attached) {
    return load_model(
        read_scene_text(above(lower, R"("attached": [{"to": "lower", )" + attached + "}]"), "s.json"), {});
  };
  const Model tied = model_of(R"("material": {})", near + R"(, "stiffness": 7)");
  ASSERT_EQ(tied.ties.size(), 9U);
  for (const Tie& tie : tied.ties) {
    EXPECT_EQ(tie.stiffness, 7.0);
    // The tet has the point straight above its top side, 0.5 high.
    const Vec3& p = at(tied.bodies.points_rest(), tie.point);
    double low_x = 9, high_x = -9, low_y = 9, high_y = -9, high_z = -9;
    for (const Index corner : at(tied.bodies.tets(), tie.tet)) {
      const Vec3& c = at(tied.bodies.points_rest(), corner);
      low_x = std::min(low_x, c.x), high_x = std::max(high_x, c.x);
      low_y = std::min(low_y, c.y), high_y = std::max(high_y, c.y);
      high_z = std::max(high_z, c.z);
    }
    EXPECT_TRUE(low_x <= p.x && p.x <= high_x && low_y <= p.y && p.y <= high_y);
    EXPECT_EQ(high_z, 0.5);
  }
  EXPECT_FALSE(model_of(R"("material": {})", near).ties.front().stiffness);
  const Model fixed = model_of(R"("obstacle": true)", near);
  EXPECT_TRUE(fixed.ties.empty());
  for (std::size_t p = 50; p < fixed.fixed_points.size(); ++p)
    EXPECT_EQ(fixed.fixed_points[p], fixed.bodies.points_rest()[p].z == 1.0 ? 1 : 0);
  EXPECT_EQ(message_of([&] { model_of(R"("obstacle": true)", near + R"(, "stiffness": 7)"); }),
            "s.json: bodies[1].attached[0].stiffness: found a stiffness, although 'to' is a rigid body, "
            "expected no stiffness: points are glued to a rigid body");
}

}  // namespace
}  // namespace palpate

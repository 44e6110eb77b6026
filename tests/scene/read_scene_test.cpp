#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "scene/error_check.hpp"
#include "scene/generators.hpp"
#include "scene/scene.hpp"

namespace palpate {
namespace {

const std::string ball = R"("ball": {"radius": 1, "resolution": 2})";
const std::string soft_ball = R"({"material": {}, )" + ball + "}";

Scene read(const std::string& text) {
  return read_scene_text(text, "s.json");
}
/// A scene of one ball with more keys at the top level.
std::string with(const std::string& keys) {
  return "{" + keys + R"(, "bodies": [)" + soft_ball + "]}";
}
/// A scene of one soft ball with more keys of the body.
std::string with_body(const std::string& keys) {
  return R"({"bodies": [{"material": {}, )" + keys + "}]}";
}
std::string problem(const std::string& text) {
  return message_of([&] { read(text); });
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(ReadScene, FillsDefaults) {
  const Scene scene = read(R"({"bodies": [)" + soft_ball + "]}");
  EXPECT_EQ(scene.settings.time_step, 0.01);
  EXPECT_EQ(scene.settings.gravity, (Vec3{0, 0, -9.81}));
  EXPECT_EQ(scene.settings.detection.cell_size, CellSize(CellSizeRule::automatic));
  EXPECT_EQ(scene.settings.detection.cells_per_primitive, std::nullopt);
  EXPECT_EQ(scene.settings.response.stiffness, std::nullopt);
  EXPECT_EQ(scene.settings.limits.max_speed, std::nullopt);
  EXPECT_EQ(scene.settings.limits.inverted_time, std::nullopt);
  EXPECT_TRUE(scene.bodies[0].regions.empty());
  EXPECT_EQ(scene.bodies[0].material.value().plastic_yield, std::nullopt);
  EXPECT_EQ(scene.units, Units{});
  ASSERT_EQ(scene.bodies.size(), 1U);
  EXPECT_EQ(scene.bodies[0].name, "body 0");
  EXPECT_EQ(scene.bodies[0].material.value().poisson_ratio, 0.4);
  EXPECT_FALSE(scene.bodies[0].obstacle);
}

TEST(ReadScene, TakesTheCompleteExampleOfTheDocumentation) {
  const std::string docs = text_of(PALPATE_SOURCE_DIR "/docs/scene.md");
  const auto begin = docs.find("```json\n{\n") + 8;
  const Scene scene = read(docs.substr(begin, docs.find("```", begin) - begin));
  EXPECT_EQ(scene.name, "example");
  EXPECT_EQ(scene.settings.time_step, 0.005);
  EXPECT_EQ(scene.duration, 2.0);
  EXPECT_EQ(scene.settings.response.friction, 0.3);
  EXPECT_EQ(scene.output.picture.camera.position.value(), (Vec3{0.4, -0.5, 0.3}));
  ASSERT_EQ(scene.bodies.size(), 3U);
  EXPECT_TRUE(scene.bodies[0].obstacle);
  EXPECT_EQ(scene.bodies[0].color.value()[2], 0.65);
  EXPECT_EQ(std::get<BoxGenerator>(scene.bodies[1].source).cells[0], 10);
  EXPECT_EQ(scene.bodies[1].material.value().stiffness_damping, 0.002);
  ASSERT_EQ(scene.bodies[1].fixed.size(), 3U);
  EXPECT_EQ(std::get<BoxSelection>(scene.bodies[1].fixed[0].points).lower.x, -0.101);
  EXPECT_EQ(std::get<SphereSelection>(scene.bodies[1].fixed[1].points).radius, 0.015);
  EXPECT_EQ(std::get<PointSelection>(scene.bodies[1].fixed[2].points).indices, (std::vector<Index>{0, 1}));
  EXPECT_EQ(std::get<BallGenerator>(scene.bodies[2].source).resolution, 5);
  EXPECT_EQ(scene.bodies[2].transform.scale, (Vec3{1, 1, 1.2}));
  EXPECT_EQ(scene.bodies[2].transform.rotate.angle, 30.0);
}

TEST(ReadScene, TakesWordsOrNumbers) {
  const Scene scene = read(with(R"("contact": {"cell_size": 0.25, "stiffness": 40, "structure": "brute"})"));
  EXPECT_EQ(scene.settings.detection.cell_size, CellSize(0.25));
  EXPECT_EQ(scene.settings.response.stiffness, 40.0);
  EXPECT_EQ(scene.settings.detection.structure, Structure::brute);
  EXPECT_EQ(read(with(R"("contact": {"cell_size": "mean-edge"})")).settings.detection.cell_size,
            CellSize(CellSizeRule::mean_edge));
  EXPECT_EQ(read(with(R"("contact": {"cells_per_primitive": 8})")).settings.detection.cells_per_primitive, 8);
}

TEST(ReadScene, NamesTheKeyOfEachError) {
  const std::string shape = R"("box": {"cells": [1, 1, 1], "size": [1, 1, 1]})";
  const std::vector<std::pair<std::string, std::string>> cases{
      {with(R"("time_step": 0)"), "time_step: found 0, expected a number > 0"},
      {with(R"("time_step": -0.1)"), "time_step: found -0.1, expected a number > 0"},
      {with(R"("time_step": "fast")"), "time_step: found \"fast\", expected a number"},
      {with(R"("time_step": null)"), "time_step: found null, expected a number"},
      {with(R"("duration": 1e999)"),
       "line 1, column 14: found 1e999, expected a number that a double can hold"},
      {with(R"("gravity": [0, 1])"), "gravity: found an array of 2, expected an array of 3 numbers"},
      {with(R"("gravity": [0, 1, true])"), "gravity[2]: found true, expected a number"},
      {with(R"("time_stpe": 1)"), "time_stpe: found unknown key, expected 'time_step'"},
      {with(R"("contact": {"structure": "compct"})"),
       "contact.structure: found \"compct\", expected 'compact'"},
      {with(R"("contact": {"structure": "octree"})"),
       "contact.structure: found \"octree\", expected one of 'uniform', 'compact', 'hash', 'cuckoo', "
       "'brute'"},
      {with(R"("contact": {"order": 1})"), "contact.order: found 1, expected one of 'linear', 'z'"},
      {with(R"("contact": {"sort": "radiks"})"), "contact.sort: found \"radiks\", expected 'radix'"},
      {with(R"("contact": {"cell_size": "mean"})"),
       "contact.cell_size: found \"mean\", expected 'auto', 'mean-edge', 'max-edge', or a number > 0"},
      {with(R"("output": {"picture": {"camera": {"position": [1, 1, 1], "target": [1, 1, 1]}}})"),
       "output.picture.camera.target: found the camera's position, expected another point"},
      {with(R"("contact": {"cells_per_primitive": 28})"),
       "contact.cells_per_primitive: found 28, expected an integer in [1, 27]"},
      {with(R"("contact": {"stiffness": -1})"), "contact.stiffness: found -1, expected a number > 0"},
      {with(R"("contact": {"friction": -1})"), "contact.friction: found -1, expected a number >= 0"},
      {with(R"("contact": [])"), "contact: found an array of 0, expected an object"},
      {with(R"("solver": {"max_iterations": 2.5})"),
       "solver.max_iterations: found 2.5, expected an integer >= 1"},
      {with(R"("solver": {"max_iterations": 99999999999})"),
       "solver.max_iterations: found 99999999999, expected an integer in [1, 2147483647]"},
      {with(R"("solver": {"fixed_iterations": 0})"),
       "solver.fixed_iterations: found 0, expected an integer >= 1"},
      {with(R"("solver": {"preconditioner": "cholesky"})"),
       "solver.preconditioner: found \"cholesky\", expected one of 'auto', 'jacobi', 'multigrid'"},
      {with(R"("rest": {"zzzzzz": 1})"), "rest.zzzzzz: found unknown key, expected one of 'speed', 'time'"},
      {with(R"("output": {"picture": {"size": [0, 100]}})"),
       "output.picture.size[0]: found 0, expected an integer in [16, 16384]"},
      {with_body(ball + R"(, "material": {})"), "bodies[0].material: found the key twice in one object"},
      {R"({"bodies": [{"material": {"young_modulos": 1}, )" + ball + "}]}",
       "bodies[0].material.young_modulos: found unknown key, expected 'young_modulus'"},
      {R"({"bodies": [)" + soft_ball + R"(, {"material": {"density": -1}, )" + ball + "}]}",
       "bodies[1].material.density: found -1, expected a number > 0"},
      {R"({"bodies": [{"material": {"poisson_ratio": 0.5}, )" + ball + "}]}",
       "bodies[0].material.poisson_ratio: found 0.5, expected a number in (-1, 0.5)"},
      {with_body(ball + R"(, "motion": {"keyframes": []})"),
       "bodies[0].motion.keyframes: found none, expected one or more"},
      {with_body(ball + R"(, "motion": {"keyframes": [{"time": 1}, {"time": 1}]})"),
       "bodies[0].motion.keyframes: found times that do not increase, expected each time later than the one "
       "before"},
      {with_body(
           ball +
           R"(, "motion": {"keyframes": [{"time": 0}, {"time": 1, "rotate": {"axis": [0, 1, 0], "angle": 360}}]})"),
       "bodies[0].motion.keyframes: found rotations about one axis by more than 180 degrees, expected at "
       "most "
       "180 degrees from one keyframe to the next"},
      {with_body(ball +
                 R"(, "motion": {"keyframes": [{"time": 0, "rotate": {"axis": [0, 0, 2], "angle": 100}},
                             {"time": 1, "rotate": {"axis": [0, 0, -1], "angle": 100}}]})"),
       "bodies[0].motion.keyframes: found rotations about one axis by more than 180 degrees"},
      {with_body(ball + R"(, "motion": {"keyframes": [{"tme": 1}]})"),
       "bodies[0].motion.keyframes[0].time: found nothing, expected a value"},
      {with_body(ball + R"(, "loads": [{"force": [0, 0, 1]}])"), "bodies[0].loads[0]"},
      {with_body(ball + R"(, "motion": {"keyframes": [{"time": 1}]}, "grabs": [
           {"from": [0, 0, 0], "target": [0, 0, 0], "stiffness": 1}])"),
       "bodies[0].grabs: found this key in a rigid body, expected a body that deforms"},
      {with_body(ball + R"(, "obstacle": true, "regions": [{"tets": [0], "material": {}}])"),
       "bodies[0].regions: found this key in a rigid body, expected a body that deforms"},
      {"{\"bodies\": [{" + ball + "}]}",
       "bodies[0].material: found nothing, expected the material of a body that is neither an obstacle nor "
       "has a motion"},
      {with_body(R"("name": "a")"),
       "bodies[0]: found none of the keys of which one is required, expected one of 'mesh', 'box', 'ball'"},
      {with_body(R"("bal": {})"), "bodies[0].bal: found unknown key, expected 'ball'"},
      {with_body(ball + ", " + shape),
       "bodies[0].ball: found this key together with 'box', expected only one of the two"},
      {with_body(R"("ball": {"radius": 1})"), "bodies[0].ball.resolution: found nothing, expected a value"},
      {with_body(R"("mesh": "")"), "bodies[0].mesh: found \"\", expected a text that is not empty"},
      {with_body(R"("box": {"cells": [1, 0, 1], "size": [1, 1, 1]})"),
       "bodies[0].box.cells[1]: found 0, expected an integer in [1, 1024]"},
      {with_body(ball + R"(, "scale": 0)"), "bodies[0].scale: found 0, expected a number > 0"},
      {with_body(ball + R"(, "scale": [1, -1, 1])"), "bodies[0].scale[1]: found -1, expected a number > 0"},
      {with_body(ball + R"(, "rotate": {"axis": [0, 0, 0]})"),
       "bodies[0].rotate.axis: found a zero vector, expected a direction"},
      {with_body(ball + R"(, "rotate": {"quaternion": [0, 0, 0, 0]})"),
       "bodies[0].rotate.quaternion: found zero"},
      {with_body(ball + R"(, "rotate": {"quaternion": [1, 0, 0, 0], "angle": 5})"),
       "bodies[0].rotate.quaternion: found 'quaternion' together with 'axis' or 'angle'"},
      {with_body(ball + R"(, "color": [0, 0, 1.5])"),
       "bodies[0].color[2]: found 1.5, expected a number in [0, 1]"},
      {with_body(ball + R"(, "obstacle": true, "self_collision": true)"),
       "bodies[0].self_collision: found true for a rigid body, expected false: a rigid body has one shape"},
      {with_body(ball + R"(, "obstacle": 1)"), "bodies[0].obstacle: found 1, expected true or false"},
      {with_body(ball + R"(, "fixed": {})"), "bodies[0].fixed: found an object, expected an array"},
      {with_body(ball + R"(, "fixed": [{"point": [1]}])"),
       "bodies[0].fixed[0].point: found unknown key, expected 'points'"},
      {with_body(ball + R"(, "fixed": [{"points": []}])"),
       "bodies[0].fixed[0].points: found an array of 0, expected an array of one or more point indices"},
      {with_body(ball + R"(, "fixed": [{"points": [-1]}])"),
       "bodies[0].fixed[0].points[0]: found -1, expected an integer >= 0"},
      {with_body(ball + R"(, "regions": [{"tets": [1]}])"),
       "bodies[0].regions[0].material: found nothing, expected a value"},
      {with_body(ball + R"(, "regions": [{"material": {}}])"),
       "bodies[0].regions[0]: found none of the keys of which one is required"},
      {with_body(ball + R"(, "regions": [{"points": [1], "material": {}}])"), "bodies[0].regions[0]"},
      {with_body(ball + R"(, "regions": [{"tets": [], "material": {}}])"),
       "bodies[0].regions[0].tets: found an array of 0, expected an array of one or more tet indices"},
      {with_body(ball + R"(, "regions": [{"tets": [0], "material": {"density": 0}}])"),
       "bodies[0].regions[0].material.density: found 0, expected a number > 0"},
      {R"({"bodies": [{"material": {"plastic_yield": 0.1}, )" + ball + "}]}",
       "bodies[0].material.plastic_creep: found nothing, expected a number >= 0, since"},
      {with(R"("limits": {"max_speed": 0})"), "limits.max_speed: found 0, expected a number > 0"},
      {with(R"("limits": {"max_speed": "none"})"),
       "limits.max_speed: found \"none\", expected 'auto' or a number > 0"},
      {with(R"("limits": {"inverted_time": 0})"), "limits.inverted_time: found 0, expected a number > 0"},
      {with_body(ball + R"(, "fixed": [{"box": {"lower": [0, 0, 0], "upper": [1, -1, 1]}}])"),
       "bodies[0].fixed[0].box.upper: found a value below 'lower', expected upper >= lower on each axis"},
      {R"({"bodies": []})", "bodies: found no body, expected one or more"},
      {"{}", "bodies: found no body, expected one or more"},
      {"[]", "found an array of 0, expected an object"},
      {R"({"bodies": [{"name": "a", "material": {}, )" + ball + R"(}, {"name": "a", "material": {}, )" +
           ball + "}]}",
       "bodies[1].name: found 'a' for the second time, expected a name that no other has"},
      {R"({"units": {"length": "inch"}, "bodies": [)" + soft_ball + "]}",
       "units.length: found 'inch', expected one of 'm', 'cm', 'mm', 'um', 'km'"},
      {R"({"units": {"mass": "kgg"}, "bodies": [)" + soft_ball + "]}",
       "units.mass: found 'kgg', expected 'kg'"},
      {R"({"units": {"length": "inch", "mass": "kgg", "time": "mss"}, "bodies": [)" + soft_ball + "]}",
       "units.length: found 'inch', expected one of 'm', 'cm', 'mm', 'um', 'km'; units.mass: found 'kgg', "
       "expected "
       "'kg'; units.time: found 'mss', expected 'ms'"},
      {with_body(ball + R"(, "loads": [{"points": [0]}])"),
       "bodies[0].loads[0].force: found nothing, expected exactly one of 'force', 'pressure' and 'traction'"},
      {with_body(ball + R"(, "loads": [{"points": [0], "force": [0, 0, 1], "pressure": 2}])"),
       "bodies[0].loads[0].pressure: found more than one of these keys, expected exactly one of"},
      {with_body(
           ball +
           R"(, "loads": [{"points": [0], "force": [0, 0, 1], "ramp": {"times": [0, 1], "factors": [1]}}])"),
       "bodies[0].loads[0].ramp.factors: found 1, expected as many as times, one or more"},
      {with_body(
           ball +
           R"(, "loads": [{"points": [0], "force": [0, 0, 1], "ramp": {"times": [1, 1], "factors": [1, 2]}}])"),
       "bodies[0].loads[0].ramp.times: found times that do not increase"},
      {with(R"("output": {"fields": ["von_misses"]})"),
       "output.fields[0]: found \"von_misses\", expected 'von_mises'"},
      {with(R"("output": {"pairs": [{"bodies": ["body 0", "body 0"]}]})"),
       "output.pairs[0].bodies: found 'body 0' twice, a body without self_collision, expected two different "
       "bodies"},
      {with(R"("output": {"pairs": [{"bodies": ["a"]}]})"),
       "output.pairs[0].bodies: found 1, expected two names"},
      {with(R"("output": {"views": [{"name": "v", "field": {"name": "stress"}}]})"),
       "output.views[0].field.name: found 'stress', expected a field of one or three components"},
      {with(R"("output": {"views": [{"name": "v", "field": {"name": "pressure", "least": 2, "most": 1}}]})"),
       "output.views[0].field.most: found a value not above 'least'"},
  };
  for (const auto& [text, expected] : cases) {
    const std::string found = problem(text);
    EXPECT_TRUE(found.starts_with("s.json: " + expected)) << text << "\n  " << found << "\n  " << expected;
    EXPECT_EQ(found.find('\n'), std::string::npos) << found;
  }
}

TEST(ReadScene, KeepsOtherUnitsWhenAllNumbersAreGiven) {
  const Scene scene = read(R"({"units": {"length": "mm", "mass": "g"}, "time_step": 0.01, "duration": 1,
      "gravity": [0, 0, -9810], "rest": {"speed": 1, "time": 0.05},
      "bodies": [{"obstacle": true, "ball": {"radius": 1, "resolution": 1}}]})");
  EXPECT_EQ(scene.units, (Units{"mm", "g", "s"}));
  EXPECT_EQ(scene.settings.gravity.z, -9810.0);
}

TEST(ReadScene, TurnsDefaultsIntoTheUnitsOfTheScene) {
  const Scene scene = read(R"({"units": {"length": "mm", "mass": "g", "time": "ms"},
      "bodies": [{"material": {}, "ball": {"radius": 1, "resolution": 1}}]})");
  EXPECT_DOUBLE_EQ(scene.settings.time_step, 10.0);
  EXPECT_DOUBLE_EQ(scene.duration, 1000.0);
  EXPECT_DOUBLE_EQ(scene.settings.gravity.z,
                   -9.81e-3);                         // mm/ms^2: 1e-3 of m/s^2 is 1e-6 of mm/ms^2, times 1e3
  EXPECT_DOUBLE_EQ(scene.settings.rest.speed, 1e-3);  // mm/ms is m/s
  EXPECT_DOUBLE_EQ(scene.settings.rest.time, 50.0);
  EXPECT_DOUBLE_EQ(scene.bodies[0].material->density, 1e-3);       // g/mm^3
  EXPECT_DOUBLE_EQ(scene.bodies[0].material->young_modulus, 0.1);  // g/(mm ms^2) is MPa
  const Scene only_length = read(R"({"units": {"length": "mm"}, "bodies": [)" + soft_ball + "]}");
  EXPECT_DOUBLE_EQ(only_length.settings.gravity.z, -9810.0);
}

/// Each known unit, with all others: defaults are worth the same in SI.
TEST(ReadScene, HasDefaultsForEveryKnownUnit) {
  const auto worth = [](const UnitName& unit) { return std::pow(10.0, unit.exponent); };
  for (const UnitName& length : length_units) {
    for (const UnitName& mass : mass_units) {
      for (const UnitName& time : time_units) {
        const std::string units = R"("length": ")" + std::string(length.name) + R"(", "mass": ")" +
                                  std::string(mass.name) + R"(", "time": ")" + std::string(time.name) + '"';
        SCOPED_TRACE(units);
        const Scene scene =
            read(R"({"units": {)" + units +
                 R"(}, "bodies": [{"material": {}, "ball": {"radius": 1, "resolution": 1}}]})");
        const double m = worth(length);
        const double kg = worth(mass);
        const double s = worth(time);
        const auto expect = [](double found, double expected) {
          EXPECT_NEAR(found, expected, 1e-12 * std::abs(expected));
        };
        expect(scene.settings.time_step * s, 0.01);
        expect(scene.settings.gravity.z * m / (s * s), -9.81);
        expect(scene.settings.rest.speed * m / s, 1e-3);
        expect(scene.bodies[0].material->density * kg / (m * m * m), 1000.0);
        expect(scene.bodies[0].material->young_modulus * kg / (m * s * s), 1e5);
      }
    }
  }
}

TEST(ReadScene, ReadsFilesAndRemembersTheirFolder) {
  const Scene scene = read_scene(PALPATE_SOURCE_DIR "/scenes/ball-on-plate.json");
  EXPECT_EQ(scene.folder, std::filesystem::path(PALPATE_SOURCE_DIR "/scenes"));
  EXPECT_EQ(scene.source, PALPATE_SOURCE_DIR "/scenes/ball-on-plate.json");
  EXPECT_EQ(message_of([] { read_scene("/no/such.json"); }),
            "/no/such.json: found no such file, expected a scene file");
  EXPECT_EQ(message_of([] { read_scene("/tmp"); }), "/tmp: found a folder, expected a scene file");
}

TEST(WriteScene, GivesTheSameSceneBack) {
  Scene scene = make_stacking_scene({.count = 2});
  scene.settings.time_step = 1.0 / 3.0;
  scene.settings.detection.cell_size = 0.1 + 0.2;
  scene.settings.detection.structure = Structure::brute;
  scene.output.picture.camera.target = Vec3{1e-300, -0.0, 5e20};
  SceneBody& body = scene.bodies[1];
  body.source = MeshFile{"some \"odd\" name \xC3\xA9.vtu"};
  body.transform.scale = {1, 2, 1.0 / 7.0};
  body.transform.rotate.quaternion = {{0.5, 0.1, 0.2, 1.0 / 3.0}};
  body.color = {{0, 0.5, 1}};
  scene.settings.limits = {.max_speed = 1.0 / 7.0, .inverted_time = 0.375};
  body.material->plastic_yield = 0.1;
  body.material->plastic_creep = 1.0 / 3.0;
  body.regions = {{BoxSelection{{0, 0, 0}, {1, 1, 1}}, {.young_modulus = 7}},
                  {TetSelection{{3, 1}}, {.plastic_maximum = 0.5}}};
  body.fixed = {{BoxSelection{{-1, -2, -3}, {1, 2, 3}}},
                {SphereSelection{}, "zx"},
                {PointSelection{{4, 2}}},
                {NearSelection{"membrane 0", 0.1, BoxSelection{{-1, -2, -3}, {1, 2, 3}}}}};
  body.attached = {{"membrane 0", PointSelection{{1}}, 1.0 / 3.0}};
  View& cut = scene.output.views.emplace_back();
  cut.name = "cut";
  cut.when = ViewTime::both;
  cut.bodies.names = {"membrane 1"};
  cut.cut = Cut{{1, 2, 3}, {0, 0, 1}, {}};
  View& map = scene.output.views.emplace_back();
  map.name = "map";
  map.displacement = DisplacementMap{1.0 / 7.0, {{"membrane 1"}}};
  map.contacts = true;
  const std::string text = write_scene(scene);
  const Scene again = read(text);
  EXPECT_EQ(write_scene(again), text);
  EXPECT_EQ(again.settings.time_step, 1.0 / 3.0);
  EXPECT_EQ(again.settings.detection.cell_size, CellSize(0.1 + 0.2));
  EXPECT_EQ(again.settings.detection.structure, Structure::brute);
  EXPECT_EQ(again.output.picture.camera.target, scene.output.picture.camera.target);
  EXPECT_EQ(std::get<MeshFile>(again.bodies[1].source).path, "some \"odd\" name \xC3\xA9.vtu");
  EXPECT_EQ(again.bodies[1].transform.scale, body.transform.scale);
  EXPECT_EQ(again.bodies[1].transform.rotate.quaternion, body.transform.rotate.quaternion);
  EXPECT_EQ(again.bodies[1].transform.translate, body.transform.translate);
  EXPECT_EQ(again.bodies[1].color, body.color);
  EXPECT_EQ(again.settings.limits.max_speed, 1.0 / 7.0);
  EXPECT_EQ(again.settings.limits.inverted_time, 0.375);
  EXPECT_EQ(again.bodies[1].material->plastic_yield, 0.1);
  EXPECT_EQ(again.bodies[1].material->plastic_creep, 1.0 / 3.0);
  EXPECT_EQ(again.bodies[1].material->plastic_maximum, std::nullopt);
  ASSERT_EQ(again.bodies[1].regions.size(), 2U);
  EXPECT_EQ(again.bodies[1].regions[0].material.young_modulus, 7.0);
  EXPECT_EQ(std::get<TetSelection>(again.bodies[1].regions[1].tets).indices, (std::vector<Index>{3, 1}));
  EXPECT_EQ(again.bodies[1].regions[1].material.plastic_maximum, 0.5);
  ASSERT_EQ(again.bodies[1].fixed.size(), 4U);
  EXPECT_EQ(again.bodies[1].fixed[1].axes, "zx");
  const auto& near = std::get<NearSelection>(again.bodies[1].fixed[3].points);
  EXPECT_EQ(near.body, "membrane 0");
  EXPECT_EQ(near.distance, 0.1);
  EXPECT_EQ(near.box->upper, (Vec3{1, 2, 3}));
  EXPECT_EQ(again.bodies[1].attached.at(0).stiffness, 1.0 / 3.0);
  ASSERT_EQ(again.output.views.size(), 2U);
  EXPECT_EQ(again.output.views[0].when, ViewTime::both);
  EXPECT_EQ(again.output.views[0].cut->normal, (Vec3{0, 0, 1}));
  EXPECT_EQ(again.output.views[0].bodies.names, std::vector<std::string>{"membrane 1"});
  EXPECT_FALSE(again.output.views[0].displacement);
  EXPECT_EQ(again.output.views[1].displacement->most, 1.0 / 7.0);
  EXPECT_TRUE(again.output.views[1].contacts);
  EXPECT_EQ(std::get<BoxSelection>(again.bodies[1].fixed[0].points).upper, (Vec3{1, 2, 3}));
  EXPECT_EQ(std::get<PointSelection>(again.bodies[1].fixed[2].points).indices, (std::vector<Index>{4, 2}));
  EXPECT_TRUE(again.bodies[0].obstacle);
}

TEST(ReadScene, RefusesViewsThatCannotBe) {
  const auto message = [](const std::string& views) {
    return message_of([&] {
      read(R"({"output": {"views": )" + views +
           R"(}, "bodies": [{"name": "a", "material": {}, "ball": {"radius": 1, "resolution": 1}}]})");
    });
  };
  EXPECT_NE(message(R"([{"name": "a/b"}])").find("output.views[0].name: found 'a/b'"), std::string::npos);
  EXPECT_NE(message(R"([{"name": "picture"}])").find("found 'picture'"), std::string::npos);
  EXPECT_NE(message(R"([{"name": "a"}, {"name": "a"}])")
                .find("output.views[1].name: found 'a' for the second time"),
            std::string::npos);
  EXPECT_NE(message(R"([{"name": "a", "bodies": ["a", "b"]}])")
                .find("output.views[0].bodies[1]: found 'b', expected 'a'"),
            std::string::npos);
  EXPECT_NE(message(R"([{"name": "a", "cut": {"point": [0, 0, 0], "normal": [0, 0, 0]}}])")
                .find("views[0].cut.normal"),
            std::string::npos);
  EXPECT_NE(message(R"([{"name": "a", "displacement": {"most": 0}}])").find("views[0].displacement.most"),
            std::string::npos);
}

TEST(WriteScene, WhatIsWrittenWithoutANameCanBeRead) {
  Scene scene = read(R"({"bodies": [{"ball": {"radius": 1, "resolution": 2}, "material": {}}]})");
  scene.name.clear();
  scene.bodies[0].name.clear();
  const Scene again = read(write_scene(scene));
  EXPECT_EQ(again.name, "");
  EXPECT_EQ(again.bodies.size(), 1U);
}

TEST(WriteScene, RefusesNumbersThatJsonCannotHold) {
  Scene scene = make_stacking_scene({.count = 2});
  scene.bodies[1].material->density = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message_of([&] { write_scene(scene); }),
            "scene: bodies[1].material.density: found nan, expected a finite number");
}

TEST(WriteScene, InBriefIsTheSameScene) {
  int count = 0;
  for (const char* folder : {PALPATE_SOURCE_DIR "/scenes", PALPATE_SOURCE_DIR "/examples/scenes"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() != ".json") continue;
      const Scene scene = read_scene(entry.path());
      const std::string brief = write_brief_scene(scene);
      EXPECT_EQ(write_scene(read_scene_text(brief, entry.path().string())), write_scene(scene)) << brief;
      EXPECT_LE(brief.size(), write_scene(scene).size());
      ++count;
    }
  }
  EXPECT_GE(count, 20);
}

TEST(WriteScene, InBriefHasWhatIsChangedFirst) {
  Scene scene =
      read(R"({"name": "a", "bodies": [{"ball": {"radius": 1, "resolution": 1}, "material": {}}]})");
  EXPECT_EQ(nlohmann::json::parse(write_brief_scene(scene)), nlohmann::json::parse(R"({
    "name": "a", "units": {"length": "m", "mass": "kg", "time": "s"}, "time_step": 0.01, "duration": 1,
    "gravity": [0, 0, -9.81], "contact": {"friction": 0},
    "bodies": [{"name": "body 0", "ball": {"radius": 1, "resolution": 1},
                "material": {"young_modulus": 1e5, "poisson_ratio": 0.4, "density": 1000}}]})"));
  scene.units.length = "mm";
  EXPECT_EQ(write_brief_scene(scene), write_scene(scene));
}

TEST(Scenes, StackingFileIsWhatTheGeneratorMakes) {
  EXPECT_EQ(text_of(PALPATE_SOURCE_DIR "/scenes/stacking.json"), write_scene(make_stacking_scene()));
}

TEST(Scenes, AllFilesCanBeRead) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(PALPATE_SOURCE_DIR "/scenes")) {
    if (entry.path().extension() != ".json") continue;
    EXPECT_EQ(message_of([&] { read_scene(entry.path()); }), "no error");
    ++count;
  }
  EXPECT_GE(count, 2);
}

TEST(ReadScene, TellsDetectionWhichBodiesTouchThemselves) {
  const Scene scene = read(R"({"bodies": [
    {"ball": {"radius": 1, "resolution": 1}, "material": {}},
    {"ball": {"radius": 1, "resolution": 1}, "material": {}, "self_collision": true}]})");
  EXPECT_EQ(scene.settings.detection.self_collision, (std::vector<std::uint8_t>{0, 1}));
  Scene named = scene;
  named.name = "strips";
  const Scene again = read(write_scene(named));
  EXPECT_FALSE(again.bodies[0].self_collision);
  EXPECT_TRUE(again.bodies[1].self_collision);
}

TEST(ReadScene, TakesTheSidesOfAPatientOneOfEachPair) {
  const auto scene_with = [](const std::string& axes) {
    const std::string body = R"({"ball": {"radius": 1, "resolution": 1}, "obstacle": true})";
    return read_scene_text(R"({"name": "patient", "axes": ")" + axes + R"(", "bodies": [)" + body + "]}",
                           "text");
  };
  EXPECT_EQ(scene_with("LPS").axes, "LPS");
  EXPECT_EQ(read_scene_text(write_scene(scene_with("RAI")), "again").axes, "RAI");
  for (const char* wrong : {"LRS", "LP", "LPSI", "xyz", ""}) {
    EXPECT_THROW(scene_with(wrong), Error) << wrong;
  }
}

}  // namespace
}  // namespace palpate

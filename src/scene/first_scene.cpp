#include "scene/first_scene.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/ball_from_above.hpp"
#include "scene/held_parts.hpp"
#include "scene/own_weight.hpp"

namespace palpate {
namespace {

/// A unit, with the likely range of the longest side of a mesh in this unit.
struct LikelyUnit {
  const char* name;
  double meters;
  double shortest;
  double longest;
};
constexpr std::array<LikelyUnit, 4> likely_units{
    {{"m", 1.0, 0.02, 0.6}, {"mm", 1e-3, 20.0, 2500.0}, {"cm", 1e-2, 2.0, 20.0}, {"um", 1e-6, 2500.0, 1e6}}};
constexpr double length_without_unit = 0.1;  // m

/// The number of a text that fmt wrote; 0 for "-0".
double number_of(const std::string& text) {
  double result = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result == 0.0 ? 0.0 : result;
}

/// Rounds to significant digits, so that the scene is easy to read.
double rounded(double value, int digits = 3) {
  return number_of(fmt::format("{:.{}g}", value, digits));
}
Vec3 rounded(const Vec3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

/// Rounds a position to decimal places of at most 1e-5 times `size`: rounding errors near zero become zero.
double rounded_position(double value, double size) {
  constexpr int most_places = 300;
  int places = 5;
  for (double scaled = size; scaled < 1.0 && places < most_places; scaled *= 10.0) ++places;
  return number_of(fmt::format("{:.{}f}", value, places));
}
Vec3 rounded_position(const Vec3& v, double size) {
  return {rounded_position(v.x, size), rounded_position(v.y, size), rounded_position(v.z, size)};
}

double longest_side(const Vec3& size) {
  return std::max({size.x, size.y, size.z});
}

constexpr double density = 1000.0;
constexpr double gravity = 9.81;
constexpr double clearance = 0.05;  // distance to the instrument, relative to the height

/// Names of the bodies, all different.
struct FirstSceneNames {
  std::string body;
  std::string file;
  std::string floor;
  std::string instrument;
};

FirstSceneNames names_for(const std::string& body, const std::string& file) {
  const auto other = [&](const char* name, const char* instead) { return body == name ? instead : name; };
  return {body, file, other("floor", "ground"), other("instrument", "tool")};
}

/// The body as placed in the scene: its centre is above the origin, its lowest point on the floor.
struct Placed {
  Bodies bodies;  ///< this body alone, in m
  Vec3 translate;
  Vec3 size;
  double volume = 0.0;
};

Placed place(const TetMesh& mesh, double meters) {
  Placed placed;
  placed.bodies.add("body", mesh);
  const MeshStatistics statistics = mesh_statistics(placed.bodies, placed.bodies.points_rest());
  const Vec3 lower = meters * statistics.lower;
  const Vec3 upper = meters * statistics.upper;
  placed.size = upper - lower;
  placed.translate = rounded_position(Vec3{-0.5 * (lower.x + upper.x), -0.5 * (lower.y + upper.y), -lower.z},
                                      longest_side(placed.size));
  placed.volume = meters * meters * meters * statistics.volume;
  std::vector<Vec3> points;
  for (const Vec3& point : placed.bodies.points_rest()) points.push_back(meters * point + placed.translate);
  placed.bodies.set_points_rest(points);
  return placed;
}

/// A material so stiff that the body hardly sags: by 1/200 of its height on average, while its lowest tenth
/// is held.
Material material_for(const Placed& placed, const HeldParts& parts) {
  constexpr double most_sag = 1.0 / 200.0;
  Material material{.young_modulus = softest_first_body,
                    .poisson_ratio = 0.4,
                    .density = density,
                    .mass_damping = 1.0,
                    .stiffness_damping = 0.01};
  const double sag = sag_under_own_weight(placed.bodies, material, parts.points) / placed.size.z;
  material.young_modulus = rounded(softest_first_body * std::max(1.0, sag / most_sag));
  return material;
}

SceneBody soft_body(const FirstSceneNames& names, const Placed& placed, const FirstSceneOptions& options) {
  SceneBody body;
  body.name = names.body;
  body.source = MeshFile{names.file};
  body.transform.scale = {options.meters, options.meters, options.meters};
  body.transform.translate = placed.translate;
  const HeldParts parts = held_parts(placed.bodies);
  body.material = material_for(placed, parts);
  if (options.drop) {
    double& height = body.transform.translate.z;
    height = rounded_position(height + 2.0 * clearance * placed.size.z, longest_side(placed.size));
  } else {
    const BoxSelection& lowest = parts.boxes.front();
    body.fixed.push_back({BoxSelection{rounded(lowest.lower), rounded(lowest.upper)}});
    // Further pieces may be small and far away: their own size, not their place, says how many digits they
    // need.
    for (std::size_t i = 1; i < parts.boxes.size(); ++i) {
      const auto& [lower, upper] = parts.boxes[i];
      const Vec3 size = upper - lower;
      const double least = std::min({size.x, size.y, size.z});
      body.fixed.push_back({BoxSelection{rounded_position(lower, least), rounded_position(upper, least)}});
    }
  }
  return body;
}

/// Side length of a square on which the body lies, even if it topples over.
double side_of_floor(const Placed& placed) {
  return 2.0 * longest_side(placed.size);
}

SceneBody floor_of(const std::string& name, const Placed& placed, const FirstSceneOptions& options) {
  const double side = side_of_floor(placed);
  const Vec3 size = rounded(Vec3{side, side, 0.05 * side});
  SceneBody floor;
  floor.name = name;
  floor.source = BoxGenerator{{4, 4, 1}, size};
  const double below = options.drop ? 0.0 : 0.02 * placed.size.z;  // a held body must not touch the floor
  floor.transform.translate.z = rounded(-(0.5 * size.z + below));
  floor.obstacle = true;
  floor.color = {0.75, 0.75, 0.75};
  return floor;
}

/// A ball that comes down on the body and stays there.
SceneBody ball_for(const std::string& name, const Placed& placed) {
  constexpr int resolution = 4;
  constexpr double press = 1.0 / 7.0;  // depth of the press, relative to the height
  const Vec3& size = placed.size;
  const auto [least, most] = std::minmax({size.x, size.y, size.z});
  const double radius = rounded(0.18 * std::sqrt(least * most));
  const double above = clearance * size.z;
  SceneBody ball;
  ball.name = name;
  ball.source = BallGenerator{radius, resolution};
  const Vec3 start = place_of_touch(placed.bodies, radius) + Vec3{0.0, 0.0, above};
  ball.transform.translate = rounded(rounded_position(start, longest_side(size)));
  const Vec3 down{0.0, 0.0, rounded(-(above + std::min(press * size.z, 0.6 * radius)))};
  SceneMotion motion;
  motion.interpolation = Interpolation::smooth;
  motion.keyframes = {{0.0, {}, {}}, {0.6, down, {}}};
  ball.motion = motion;
  ball.color = {0.55, 0.6, 0.65};
  return ball;
}

/// A plate above the body, wider than it.
SceneBody plate_for(const std::string& name, const Placed& placed) {
  const double side = 0.7 * side_of_floor(placed);
  const Vec3 size = rounded(Vec3{side, side, 0.02 * side});
  SceneBody plate;
  plate.name = name;
  plate.source = BoxGenerator{{4, 4, 1}, size};
  plate.transform.translate.z = rounded((1.0 + 4.0 * clearance) * placed.size.z + 0.5 * size.z);
  plate.motion.emplace().keyframes = {{0.0, {}, {}}};
  plate.color = {0.55, 0.6, 0.65};
  return plate;
}

/// A camera at the side, so low that the plate does not hide the body.
Camera camera_below_the_plate(const Placed& placed) {
  const double side = side_of_floor(placed);
  return {.position = rounded(Vec3{0.8 * side, -1.3 * side, 0.2 * placed.size.z}),
          .target = Vec3{0.0, 0.0, rounded(0.25 * placed.size.z)}};
}

/// Two stages: the body falls and comes to rest; then the plate comes down until it presses, and stays there.
/// The motion ends at a given force, because it is not known beforehand how the body will lie.
std::vector<Stage> stages_of_drop(const FirstSceneNames& names, double mass, const Placed& placed) {
  constexpr double weights = 2.0;
  constexpr double time = 4.0;
  const double travel = (1.0 + 4.0 * clearance) * placed.size.z;
  const auto move = [&](double translate) {
    SceneMotion motion;
    motion.keyframes = {{0.0, {}, {}}};
    if (translate != 0.0) motion.keyframes.push_back({time, {0.0, 0.0, rounded(translate)}, {}});
    return std::vector<StageMove>{{.body = names.instrument, .motion = motion}};
  };
  std::vector<Stage> stages(3);
  stages[0].name = "fall";
  stages[0].until = {.rest = true, .most = 2.0};
  stages[1].name = "press";
  stages[1].move = move(-travel);
  stages[1].until = {.force = ForceReached{.body = names.body,
                                           .from = names.instrument,
                                           .at_least = rounded(weights * gravity * mass)},
                     .most = time};
  stages[2].name = "hold";
  stages[2].move = move(0.0);
  stages[2].until = {.time = 0.2};
  return stages;
}

}  // namespace

std::optional<MeshUnit> mesh_unit(std::string_view name) {
  for (const LikelyUnit& unit : likely_units) {
    if (unit.name == name) return MeshUnit{unit.name, unit.meters};
  }
  return std::nullopt;
}

MeshUnit guess_unit(double longest_side) {
  for (const LikelyUnit& unit : likely_units) {
    if (unit.shortest <= longest_side && longest_side <= unit.longest) return {unit.name, unit.meters};
  }
  return {"", rounded(length_without_unit / longest_side)};
}

FirstScene make_first_scene(const std::string& name, const std::string& file, const TetMesh& mesh,
                            const FirstSceneOptions& wanted) {
  FirstSceneOptions options = wanted;
  constexpr int digits_of_scale = 6;
  options.meters = rounded(wanted.meters, digits_of_scale);
  if (!std::isfinite(options.meters) || options.meters <= 0.0)
    throw Error("make_first_scene", "meters", fmt::format("{}", options.meters), "a number > 0");
  const Placed placed = place(mesh, options.meters);
  FirstScene first{.scene = {}, .size = placed.size, .mass = density * placed.volume};
  Scene& scene = first.scene;
  scene.name = name;
  scene.settings.response.friction = 0.3;
  scene.output.every = 5;
  const FirstSceneNames names = names_for(name, file);
  scene.bodies = {soft_body(names, placed, options), floor_of(names.floor, placed, options),
                  options.drop ? plate_for(names.instrument, placed) : ball_for(names.instrument, placed)};
  // A slender body is made so stiff that a step needs more iterations than usual.
  constexpr double stiff = 1e7;
  constexpr int many_iterations = 2000;
  if (scene.bodies.front().material->young_modulus > stiff)
    scene.settings.solver.max_iterations = many_iterations;
  if (options.drop) {
    scene.stages = stages_of_drop(names, first.mass, placed);
    scene.output.picture.camera = camera_below_the_plate(placed);
    scene.duration = 0.0;
    for (const Stage& stage : scene.stages) scene.duration += stage.until.limit();
  } else {
    scene.duration = 1.0;
  }
  return first;
}

}  // namespace palpate

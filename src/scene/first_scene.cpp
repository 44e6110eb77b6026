#include "scene/first_scene.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <limits>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"

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

/// Rounds to three digits, so that the scene is easy to read.
double rounded(double value) {
  const std::string text = fmt::format("{:.3g}", value);
  double result = value;
  std::from_chars(text.data(), text.data() + text.size(), result);
  return result;
}
Vec3 rounded(const Vec3& v) {
  return {rounded(v.x), rounded(v.y), rounded(v.z)};
}

/// The body in the scene: its centre above the origin, its lowest point on the floor.
struct Placed {
  Vec3 translate;
  Vec3 size;
  Vec3 top;  ///< the highest point that is nearest to the centre
  double volume;
};

Placed place(const TetMesh& mesh, double meters) {
  Bodies bodies;
  bodies.add("body", mesh);
  const MeshStatistics statistics = mesh_statistics(bodies, bodies.points_rest());
  const Vec3 lower = meters * statistics.lower;
  const Vec3 upper = meters * statistics.upper;
  Placed placed{
      .translate = {0.0 - 0.5 * (lower.x + upper.x), 0.0 - 0.5 * (lower.y + upper.y), 0.0 - lower.z},
      .size = upper - lower,
      .top = {},
      .volume = meters * meters * meters * statistics.volume};
  constexpr double high = 0.95;  // of the height
  double nearest = std::numeric_limits<double>::infinity();
  for (const Tet& tet : mesh.tets) {
    for (const Index corner : tet) {
      const Vec3 point = meters * at(mesh.points, corner) + placed.translate;
      const double off_middle = point.x * point.x + point.y * point.y;
      if (point.z < high * placed.size.z || off_middle >= nearest) continue;
      nearest = off_middle;
      placed.top = point;
    }
  }
  return placed;
}

constexpr double density = 1000.0;
constexpr double gravity = 9.81;
constexpr double held = 0.1;        // of the height
constexpr double clearance = 0.05;  // distance to the instrument, over the height

SceneBody soft_body(const std::string& name, const std::string& file, const Placed& placed,
                    const FirstSceneOptions& options) {
  constexpr double softest = 20e3;
  constexpr double stiffness_by_weight = 25.0;
  const double height = placed.size.z;
  SceneBody body;
  body.name = name;
  body.source = MeshFile{file};
  body.transform.scale = {options.meters, options.meters, options.meters};
  body.transform.translate = placed.translate;
  if (options.drop) body.transform.translate.z += 2.0 * clearance * height;
  body.material =
      Material{.young_modulus = rounded(std::max(softest, stiffness_by_weight * density * gravity * height)),
               .poisson_ratio = 0.4,
               .density = density,
               .mass_damping = 1.0,
               .stiffness_damping = 0.01};
  if (!options.drop) {
    const Vec3 room = placed.size;
    body.fixed.push_back({BoxSelection{rounded(Vec3{-room.x, -room.y, -held * height}),
                                       rounded(Vec3{room.x, room.y, held * height})}});
  }
  return body;
}

SceneBody floor_of(const Placed& placed, const FirstSceneOptions& options) {
  const double side = std::max(placed.size.x, placed.size.y);
  const double thickness = 0.1 * std::max(side, placed.size.z);
  const Vec3 size = rounded(Vec3{2.0 * side, 2.0 * side, thickness});
  SceneBody floor;
  floor.name = "floor";
  floor.source = BoxGenerator{{4, 4, 1}, size};
  const double below = options.drop ? 0.0 : 0.02 * placed.size.z;  // a held body must not touch the floor
  floor.transform.translate.z = rounded(-(0.5 * size.z + below));
  floor.obstacle = true;
  floor.color = {0.75, 0.75, 0.75};
  return floor;
}

SceneBody instrument(const Placed& placed, const FirstSceneOptions& options) {
  constexpr int resolution = 4;
  constexpr double press = 1.0 / 7.0;  // of the height
  const double height = placed.size.z;
  const double radius =
      rounded(0.15 * std::min({placed.size.x, placed.size.y, placed.size.z}) + 0.02 * height);
  const double above = (options.drop ? 3.0 : 1.0) * clearance * height;
  SceneBody ball;
  ball.name = "instrument";
  ball.source = BallGenerator{radius, resolution};
  ball.transform.translate = rounded(placed.top + Vec3{0.0, 0.0, radius + above});
  const Vec3 down{0.0, 0.0, rounded(-(above + press * height))};
  const double start = options.drop ? 0.5 : 0.0;
  SceneMotion motion;
  motion.interpolation = Interpolation::smooth;
  motion.keyframes = {
      {start, {}, {}}, {start + 0.5, down, {}}, {start + 1.0, down, {}}, {start + 1.5, {}, {}}};
  ball.motion = motion;
  ball.color = {0.55, 0.6, 0.65};
  return ball;
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
                            const FirstSceneOptions& options) {
  if (!std::isfinite(options.meters) || options.meters <= 0.0)
    throw Error("make_first_scene", "meters", fmt::format("{}", options.meters), "a number > 0");
  const Placed placed = place(mesh, options.meters);
  FirstScene first{.scene = {}, .size = placed.size, .mass = density * placed.volume};
  Scene& scene = first.scene;
  scene.name = name;
  scene.settings.response.friction = 0.3;
  // Real meshes have thin rims, through which the instrument could pass within a step.
  scene.settings.detection.continuous = true;
  scene.duration = options.drop ? 2.5 : 2.0;
  scene.output.every = 5;
  scene.bodies = {soft_body(name, file, placed, options), floor_of(placed, options),
                  instrument(placed, options)};
  return first;
}

}  // namespace palpate

#include "measure/query_scenes.hpp"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "anatomy/shapes.hpp"
#include "anatomy/stuffing.hpp"
#include "geometry/rotation.hpp"
#include "geometry/vector.hpp"
#include "scene/generators.hpp"
#include "scene/load.hpp"

namespace palpate::measure {
namespace {

/// Uniform in [-1, 1], from its arguments alone: the finaliser of SplitMix64.
double random_unit(std::uint64_t stream, std::uint64_t index) {
  std::uint64_t z = (stream << 40U) + index + 1;
  z *= 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return std::ldexp(static_cast<double>(z >> 11U), -52) - 1.0;
}

/// Chooses the motion of points. Two random numbers in [-a, a] differ by 2 a / 3 on average, and each of
/// three axes may move a point to another cell. So a tremble of a gives a fraction of 2 a / cell movers. A
/// shift of two cells moves all points.
void start(QueryScene& scene, double movers = 0.02) {
  scene.places.assign(scene.bodies.points_rest().begin(), scene.bodies.points_rest().end());
  scene.self_collision.assign(scene.bodies.bodies().size(), 0);
  const double cell_size = mesh_statistics(scene.bodies, scene.places).edge_length.mean;
  const bool all = movers >= 1.0;
  scene.tremble = (all ? 0.02 : movers) * cell_size / 2.0;
  scene.shift = all ? 2.0 * cell_size : 0.0;
}

void make_uneven(std::vector<Vec3>& places) {
  for (std::size_t p = 0; p < places.size(); ++p) places[p].z += 0.0012 * random_unit(1, p) - 0.0002;
}

}  // namespace

Model stacking_model(int cells) {
  StackingOptions options;
  options.cells = {cells, cells, 1};
  options.size = {0.02 * cells, 0.02 * cells, 0.01};
  options.gap = 0.0;
  return load_model(make_stacking_scene(options), {});
}

std::vector<std::uint8_t> QueryScene::immovable() const {
  std::vector<std::uint8_t> marks(bodies.bodies().size(), 0);
  marks[0] = bodies.body_count() > 1 ? 1 : 0;
  return marks;
}

void QueryScene::place(std::uint32_t frame, std::vector<Vec3>& positions) const {
  positions.resize(places.size());
  const std::uint64_t stream = 16 + std::uint64_t{frame} * 4;
  for (std::size_t p = 0; p < places.size(); ++p) {
    const Vec3 method{random_unit(stream, p), random_unit(stream + 1, p), random_unit(stream + 2, p)};
    positions[p] = places[p] + tremble * method;
    if (frame % 2 == 1) positions[p].x += shift;
  }
}

int stacking_cells(double tets) {
  return static_cast<int>(std::lround(std::sqrt(tets / (20.0 * 5.0))));
}

QueryScene stacking_scene(int cells, double movers) {
  QueryScene scene;
  scene.bodies = stacking_model(cells).bodies;
  scene.name = "stacking " + std::to_string(scene.bodies.tets().size());
  start(scene, movers);
  make_uneven(scene.places);
  return scene;
}

QueryScene pile_scene() {
  QueryScene scene;
  scene.name = "pile";
  for (int b = 0; b < 27; ++b) {
    const bool ball = b % 2 == 0;
    TetMesh mesh = ball ? make_ball(0.58, 4 + b % 5) : make_box({5 + b % 4, 6, 5}, {1.05, 1.05, 1.05});
    const Vec3 axis{1.0 + random_unit(2, static_cast<std::uint64_t>(b)), 1.0, 0.5};
    const Quaternion rotation = rotation_about(axis, 37.0 * b);
    const std::div_t layer = std::div(b, 9);
    const std::div_t row = std::div(layer.rem, 3);
    const Vec3 centre{static_cast<double>(row.rem), static_cast<double>(row.quot),
                      static_cast<double>(layer.quot)};
    for (Vec3& p : mesh.points) p = rotated(rotation, p) + centre;
    scene.bodies.add((ball ? "ball " : "box ") + std::to_string(b), std::move(mesh));
  }
  start(scene);
  return scene;
}

QueryScene tubes_scene() {
  constexpr int layers = 4;
  constexpr int abreast = 4;
  constexpr int parts = 16;
  constexpr double radius = 1.0;
  constexpr double apart = 1.85;  // distance of neighbours, less than the diameter
  constexpr double length = 8.0;
  QueryScene scene;
  scene.name = "tubes";
  for (int b = 0; b < layers * abreast; ++b) {
    const std::div_t layer = std::div(b, abreast);
    const bool along_x = layer.quot % 2 == 0;
    const double side = apart * (layer.rem - 0.5 * (abreast - 1));
    std::vector<anatomy::TubeStation> stations;
    for (int i = 0; i <= parts; ++i) {
      const double method = length * (static_cast<double>(i) / parts - 0.5);
      const double bend = 0.3 * std::sin(method + layer.quot);
      const Vec3 centre{along_x ? method : side + bend, along_x ? side + bend : method, apart * layer.quot};
      stations.push_back({centre, {0.0, 0.0, 1.0}, radius, radius});
    }
    constexpr double reach = 0.5 * length + 2.0 * radius;
    const double z = apart * layer.quot;
    scene.bodies.add("tube " + std::to_string(b), anatomy::stuff(anatomy::tube(std::move(stations)),
                                                                 {.lower = {-reach, -reach, z - 1.5 * radius},
                                                                  .upper = {reach, reach, z + 1.5 * radius},
                                                                  .cell = 0.4 + 0.04 * (b % 5)}));
  }
  start(scene);
  return scene;
}

QueryScene raptors_scene(TetMesh left, TetMesh right) {
  QueryScene scene;
  scene.name = "raptors";
  scene.bodies.add("left", std::move(left));
  for (Vec3& p : right.points) p = p + Vec3{3.0, 0.0, 0.5};
  scene.bodies.add("right", std::move(right));
  start(scene);
  return scene;
}

QueryScene shipped_scene(std::string name, Bodies bodies) {
  QueryScene scene;
  scene.name = std::move(name);
  scene.bodies = std::move(bodies);
  start(scene);
  return scene;
}

QueryScene self_scene() {
  QueryScene scene;
  scene.name = "self-collision";
  const Model model = stacking_model(10);
  TetMesh mesh;
  mesh.points.assign(model.bodies.points_rest().begin(), model.bodies.points_rest().end());
  mesh.tets.assign(model.bodies.tets().begin(), model.bodies.tets().end());
  scene.bodies.add("all", std::move(mesh));
  start(scene);
  make_uneven(scene.places);
  scene.self_collision.assign(1, 1);
  return scene;
}

}  // namespace palpate::measure

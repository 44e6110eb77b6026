// Scenes that need no file. Names say what differs: kind, tets, Young's modulus, and what else is not usual.
#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "geometry/vector.hpp"
#include "scene/generators.hpp"
#include "steps/catalogue.hpp"
#include "steps/slivers.hpp"

namespace palpate::bench {
namespace {

struct Stiffness {
  double young = 0.0;  ///< Pa
  std::string_view name;
};
constexpr Stiffness kPa1{1e3, "1kPa"};
constexpr Stiffness kPa5{5e3, "5kPa"};
constexpr Stiffness MPa1{1e6, "1MPa"};
constexpr Stiffness MPa100{1e8, "100MPa"};
constexpr Stiffness GPa1{1e9, "1GPa"};

void add_body(StepModel& scene, std::string name, TetMesh mesh, const Vec3& place, const Material& material,
              bool obstacle = false) {
  for (Vec3& p : mesh.points) p += place;
  scene.model.bodies.add(std::move(name), std::move(mesh));
  scene.model.materials.push_back(material);
  scene.model.obstacles.push_back(obstacle ? 1 : 0);
}

/// A plate whose upper side is at z = 0. Its grid is not that of what falls on it.
void add_floor(StepModel& scene, double size) {
  add_body(scene, "floor", make_box({8, 8, 1}, {size, size, 0.05}), {0.011, 0.007, -0.025}, {}, true);
}

/// Fixes the points whose `coordinate` is the least of all.
void fix_end(StepModel& scene, double Vec3::*coordinate) {
  const auto points = scene.model.bodies.points_rest();
  const double least = (*std::ranges::min_element(points, {}, coordinate)).*coordinate;
  for (const Vec3& p : points) scene.model.fixed_points.push_back(p.*coordinate <= least + 1e-9 ? 1 : 0);
}

std::size_t box_tets(const std::array<int, 3>& cells) {
  return std::size_t{5} * static_cast<std::size_t>(cells[0]) * static_cast<std::size_t>(cells[1]) *
         static_cast<std::size_t>(cells[2]);
}

/// A cantilever of 0.8 x 0.1 x 0.1 m that bends under its weight.
StepScene beam(std::string name, int cells, const Material& material, int steps, bool half_soft = false) {
  const std::array<int, 3> all{8 * cells, cells, cells};
  const auto make = [=] {
    StepModel scene;
    add_body(scene, "beam", make_box(all, {0.8, 0.1, 0.1}), {}, material);
    fix_end(scene, &Vec3::x);
    if (half_soft) {
      scene.model.materials.push_back({1e-4 * material.young_modulus, material.poisson_ratio});
      const auto points = scene.model.bodies.points_rest();
      for (const Tet& tet : scene.model.bodies.tets())
        scene.model.material_of_tet.push_back(at(points, tet[0]).x < 0.0 ? 0 : 1);
    }
    return scene;
  };
  return {.name = std::move(name),
          .steps = steps,
          .quick_steps = std::min(steps, 10),
          .tets = box_tets(all),
          .make = make};
}

/// A cube of 0.5 m that stands fixed on its lower side; 20 ms a step.
StepScene block(std::string_view size, int cells, const Stiffness& stiffness, double poisson, int steps) {
  std::string name = fmt::format("block-{}-{}", size, stiffness.name);
  if (poisson > 0.45) name += fmt::format("-nu{}", poisson);
  const auto make = [=] {
    StepModel scene;
    scene.settings.time_step = 0.02;
    add_body(scene, "block", make_box({cells, cells, cells}, {0.5, 0.5, 0.5}), {},
             {stiffness.young, poisson});
    fix_end(scene, &Vec3::z);
    return scene;
  };
  return {.name = name,
          .steps = steps,
          .quick_steps = std::min(steps, 5),
          .tets = box_tets({cells, cells, cells}),
          .make = make};
}

/// A tower of slabs with a hair's breadth between them; materials by turns.
StepScene tower(std::string name, int count, const std::array<int, 3>& cells, int steps,
                const std::vector<Material>& materials) {
  const auto make = [=] {
    StepModel scene;
    scene.settings.time_step = 0.02;
    scene.settings.response.friction = 0.5;
    add_floor(scene, 1.2);
    for (int i = 0; i < count; ++i) {
      const Vec3 place{0.003 * hashed_unit(1, static_cast<std::uint64_t>(i), 0),
                       0.003 * hashed_unit(1, static_cast<std::uint64_t>(i), 1), 0.0501 + 0.1001 * i};
      add_body(scene, fmt::format("slab {}", i), make_box(cells, {0.3, 0.3, 0.1}), place,
               materials[static_cast<std::size_t>(i) % materials.size()]);
    }
    return scene;
  };
  const std::size_t tets = box_tets({8, 8, 1}) + static_cast<std::size_t>(count) * box_tets(cells);
  return {.name = std::move(name),
          .steps = steps,
          .quick_steps = std::min(steps, 25),
          .tets = tets,
          .make = make};
}

/// Balls that fall on a floor and on each other.
StepScene pile(std::string name, int count, int layers, const Material& material, bool slivers, int steps) {
  constexpr double radius = 0.05;
  const auto make = [=] {
    StepModel scene;
    scene.settings.response.friction = 0.3;
    add_floor(scene, 0.8);
    for (int i = 0; i < count; ++i) {
      const auto index = static_cast<std::uint64_t>(i);
      TetMesh mesh = make_ball(radius, layers);
      if (slivers) make_slivers(mesh, index);
      const Vec3 place{0.03 * (hashed_unit(2, index, 0) - 0.5), 0.03 * (hashed_unit(2, index, 1) - 0.5),
                       1.04 * radius + 2.08 * radius * i};
      add_body(scene, fmt::format("ball {}", i), std::move(mesh), place, material);
    }
    return scene;
  };
  const auto layer_count = static_cast<std::size_t>(layers);
  const std::size_t tets =
      box_tets({8, 8, 1}) + static_cast<std::size_t>(count) * 20 * layer_count * layer_count * layer_count;
  return {.name = std::move(name),
          .steps = steps,
          .quick_steps = std::min(steps, 40),
          .tets = tets,
          .make = make};
}

/// Many small balls in layers that are moved sideways by turns, so that they fall between each other; 5 ms a
/// step.
StepScene crowd(std::string name, int side, const Material& material, int steps) {
  constexpr double radius = 0.01;
  const auto make = [=] {
    StepModel scene;
    scene.settings.time_step = 0.005;
    scene.settings.response.friction = 0.3;
    add_floor(scene, 0.8);
    for (int i = 0; i < side * side * side; ++i) {
      const int x = i % side;
      const int y = i / side % side;
      const int z = i / side / side;
      const Vec3 place{0.022 * x + 0.002 * (z % 2), 0.022 * y, 0.011 + 0.021 * z};
      add_body(scene, fmt::format("ball {}", i), make_ball(radius, 1), place - Vec3{0.05, 0.05, 0.0},
               material);
    }
    return scene;
  };
  return {.name = std::move(name),
          .steps = steps,
          .quick_steps = std::min(steps, 40),
          .tets = box_tets({8, 8, 1}) + 20 * static_cast<std::size_t>(side * side * side),
          .make = make};
}

/// The two ends of a bar along x, driven by motions: the end at the larger x moves by `travel` in half a
/// second.
void drive_ends(StepModel& scene, double travel) {
  const auto points = scene.model.bodies.points_rest();
  const auto [least, most] = std::ranges::minmax(points, {}, &Vec3::x);
  scene.model.motions = {{.center = {}, .keyframes = {{.time = 0.0}}},
                         {.center = {},
                          .keyframes = {{.time = 0.0}, {.time = 0.5, .translate = {travel, 0.0, 0.0}}},
                          .interpolation = Interpolation::smooth}};
  for (const Vec3& p : points)
    scene.model.motion_of_point.push_back(p.x <= least.x + 1e-9 ? 0 : p.x >= most.x - 1e-9 ? 1 : -1);
}

/// A bar of 80 x 20 x 20 mm whose ends are driven towards each other (travel < 0) or apart.
StepScene driven_bar(std::string name, const Material& material, double travel) {
  constexpr std::array<int, 3> cells{16, 4, 4};
  const auto make = [=] {
    StepModel scene;
    scene.settings.gravity = {};
    add_body(scene, "bar", make_box(cells, {0.08, 0.02, 0.02}), {}, material);
    drive_ends(scene, travel);
    return scene;
  };
  return {.name = std::move(name), .steps = 80, .quick_steps = 40, .tets = box_tets(cells), .make = make};
}

/// A muscle along x, fixed at one end, whose fibres contract and pull it over an obstacle that it lies on.
StepScene muscle(std::string name, const Material& material) {
  constexpr std::array<int, 3> cells{16, 4, 4};
  const auto make = [=] {
    StepModel scene;
    scene.settings.response.friction = 0.2;
    add_floor(scene, 0.3);
    add_body(scene, "muscle", make_box(cells, {0.08, 0.02, 0.02}), {0.0, 0.0, 0.0101}, material);
    const auto points = scene.model.bodies.points_rest();
    for (const Vec3& p : points) scene.model.fixed_points.push_back(p.z > 0.0 && p.x <= -0.04 + 1e-9 ? 1 : 0);
    return scene;
  };
  return {.name = std::move(name),
          .steps = 100,
          .quick_steps = 40,
          .tets = box_tets({8, 8, 1}) + box_tets(cells),
          .make = make};
}

/// A sheet that falls over a fixed ball.
StepScene draped(std::string name, const Material& material) {
  constexpr std::array<int, 3> cells{20, 20, 1};
  constexpr int layers = 5;
  const auto make = [=] {
    StepModel scene;
    scene.settings.response.friction = 0.3;
    add_body(scene, "ball", make_ball(0.04, layers), {0.003, 0.002, -0.041}, {}, true);
    add_body(scene, "sheet", make_box(cells, {0.16, 0.16, 0.004}), {0.0, 0.0, 0.003}, material);
    return scene;
  };
  return {.name = std::move(name),
          .steps = 100,
          .quick_steps = 40,
          .tets = box_tets(cells) + std::size_t{20} * layers * layers * layers,
          .make = make};
}

/// Tissue with large strains, smoothed tets, fibres and damping.
void add_tissue(std::vector<StepScene>& scenes) {
  constexpr auto neo = MaterialModel::stable_neo_hookean;
  const Material neo20{.young_modulus = 2e4, .poisson_ratio = 0.45, .model = neo};
  Material smoothed20 = neo20;
  smoothed20.poisson_ratio = 0.49;
  smoothed20.elements = ElementKind::smoothed;
  Material corotational20 = smoothed20;
  corotational20.model = MaterialModel::corotational;
  Material mooney20 = neo20;
  mooney20.model = MaterialModel::mooney_rivlin;
  Material stiffer = neo20;
  stiffer.young_modulus = 1e5;
  scenes.push_back(beam("beam-10k-neo-100kPa", 6, stiffer, 50));
  stiffer = corotational20;
  stiffer.young_modulus = 1e5;
  scenes.push_back(beam("beam-10k-smoothed-100kPa-nu0.49", 6, stiffer, 50));
  scenes.push_back(driven_bar("squeezed-neo", neo20, -0.04));
  scenes.push_back(driven_bar("squeezed-mooney", mooney20, -0.04));
  scenes.push_back(driven_bar("squeezed-smoothed", smoothed20, -0.04));
  scenes.push_back(driven_bar("stretched-neo", neo20, 0.08));
  Material active = neo20;
  active.fibres = {.stiffness = 1e4,
                   .exponent = 1.0,
                   .active_stress = 1e4,
                   .activation = {.times = {0.05, 0.3}, .factors = {0.0, 1.0}}};
  scenes.push_back(muscle("muscle-neo", active));
  active.poisson_ratio = smoothed20.poisson_ratio;
  active.elements = ElementKind::smoothed;
  scenes.push_back(muscle("muscle-smoothed", active));
  scenes.push_back(draped("draped-neo", neo20));
  scenes.push_back(draped("draped-smoothed", smoothed20));
  scenes.push_back(pile("pile-balls-neo-20kPa", 6, 4, neo20, false, 150));
  scenes.push_back(pile("pile-slivers-neo-20kPa", 6, 4, neo20, true, 150));
  scenes.push_back(pile("pile-balls-smoothed-20kPa", 6, 4, corotational20, false, 150));
  Material damped{.young_modulus = 2e4, .mass_damping = 0.5, .stiffness_damping = 0.01};
  damped.viscosity = {.fractions = {0.3, 0.2}, .times = {0.02, 0.5}};
  scenes.push_back(pile("pile-balls-damped-20kPa", 6, 4, damped, false, 150));
}

void add_beams(std::vector<StepScene>& scenes) {
  constexpr double usual = 0.3;
  const auto add = [&](std::string_view size, int cells, const Stiffness& s, double poisson, int steps) {
    std::string name = fmt::format("beam-{}-{}", size, s.name);
    if (poisson > 0.45) name += fmt::format("-nu{}", poisson);
    scenes.push_back(beam(std::move(name), cells, {s.young, poisson}, steps));
  };
  for (const Stiffness& s : {kPa1, MPa1, GPa1}) {
    add("1k", 3, s, usual, 100);
    add("10k", 6, s, usual, 50);
    add("100k", 14, s, usual, 10);
  }
  for (const double poisson : {0.49, 0.499}) add("10k", 6, MPa1, poisson, 50);
  add("100k", 14, MPa1, 0.499, 10);
  add("1M", 29, MPa1, usual, 3);
  for (const Stiffness& s : {MPa1, MPa100}) {
    scenes.push_back(block("11k", 13, s, usual, 20));
    scenes.push_back(block("98k", 27, s, usual, 10));
    scenes.push_back(block("1M", 58, s, usual, 3));
  }
  for (const double poisson : {0.49, 0.499}) scenes.push_back(block("11k", 13, MPa1, poisson, 20));
}

}  // namespace

std::vector<StepScene> generated_scenes() {
  std::vector<StepScene> scenes;
  add_beams(scenes);
  constexpr std::array<int, 3> coarse{6, 6, 2};
  for (const Stiffness& s : {MPa1, MPa100, GPa1})
    scenes.push_back(tower(fmt::format("slabs-10-{}", s.name), 10, coarse, 100, {{s.young}}));
  scenes.push_back(tower("slabs-10-fine-100MPa", 10, {12, 12, 4}, 50, {{MPa100.young}}));
  for (const Stiffness& s : {kPa5, MPa1}) {
    scenes.push_back(pile(fmt::format("pile-balls-{}", s.name), 6, 4, {s.young}, false, 150));
    scenes.push_back(pile(fmt::format("pile-slivers-{}", s.name), 6, 4, {s.young}, true, 150));
  }
  scenes.push_back(pile("pile-slivers-fine-5kPa", 4, 8, {kPa5.young}, true, 80));
  scenes.push_back(crowd("crowd-125-50kPa", 5, {5e4}, 100));
  scenes.push_back(crowd("crowd-125-10MPa", 5, {1e7}, 100));
  // Neighbours of other kinds: the heaviest weighs what a tower of water would, the softest carries it.
  const Material soft{2e4};
  const Material stiff{2e8};
  scenes.push_back(tower("unlike-stiffness", 4, {6, 6, 3}, 100, {soft, stiff}));
  scenes.push_back(
      tower("unlike-mass", 4, {6, 6, 3}, 100, {{MPa1.young, 0.4, 20.0}, {MPa1.young, 0.4, 2e4}}));
  scenes.push_back(tower("unlike-both", 4, {6, 6, 3}, 100, {{2e5, 0.4, 20.0}, {2e9, 0.4, 2e4}}));
  scenes.push_back(beam("unlike-within-10k", 6, {MPa100.young, 0.3}, 50, true));
  add_tissue(scenes);
  return scenes;
}

}  // namespace palpate::bench

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "anatomy/fit.hpp"
#include "anatomy/organs.hpp"
#include "anatomy/plate.hpp"
#include "anatomy/round_points.hpp"
#include "anatomy/shapes.hpp"
#include "anatomy/stuffing.hpp"
#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

/// Between organs that touch: more than what chords of a curved surface deviate from it.
constexpr double gap = 0.2;
constexpr double bulb_radius = 12.0;
constexpr double plate_thickness = 0.8;
constexpr double plate_cell = 1.9;
constexpr std::array<int, 2> plate_cells{9, 11};
constexpr Vec3 plate_start{-0.5 * 9 * plate_cell, -2.0, 0.0};

/// The bulb with the bulge of the cornea.
Distance bulb_shape() {
  return smoothly_united(ball({}, bulb_radius), ball({0.0, -5.3, 0.0}, 7.8), 1.5);
}

/// The inside of the bony orbit: a cone that narrows to the apex, with a floor that rises to the back.
Distance cavity_shape() {
  return smoothly_common(round_cone({0.0, 1.0, 0.0}, {0.0, 34.0, 0.0}, 21.0, 6.5),
                         half_space({0.0, 0.0, -19.2}, {0.0, 0.25, -1.0}), 4.0);
}

/// The front of the bones of the face.
Distance face_shape() {
  return ball({0.0, 56.0, 0.0}, 66.0);
}

Distance bone_shape() {
  const Distance cavity = cavity_shape();
  const Distance wall = common({layer(cavity, -8.0, 7.0), face_shape()});
  const Distance rim = smoothly_common(layer(face_shape(), -7.0, 0.0), ball({0.0, -4.0, 0.0}, 31.0), 6.0);
  return smoothly_without(united({wall, rim}), cavity, 5.0);
}

/// A rectus that lies on the bulb and runs to the apex; `angle` (degrees) is where it lies around the axis of
/// the orbit.
Distance rectus_shape(double angle) {
  constexpr double depth = 2.5;
  constexpr double reach = bulb_radius + gap + depth;
  constexpr double apex_reach = 4.6;
  constexpr double apex_y = 30.5;
  const double radians = angle * std::numbers::pi / 180.0;
  const Vec3 outward{std::cos(radians), 0.0, std::sin(radians)};
  const Vec3 across{-std::sin(radians), 0.0, std::cos(radians)};
  // Where the straight line from the apex touches the bulb.
  const double touch = std::atan2(apex_y, apex_reach) - std::acos(reach / std::hypot(apex_reach, apex_y));
  const double insertion = -20.0 * std::numbers::pi / 180.0;
  constexpr int parts = 6;
  std::vector<TubeStation> stations;
  stations.reserve(parts + 2);
  for (int i = 0; i <= parts; ++i) {
    const double fraction = static_cast<double>(i) / parts;
    const double position = insertion + fraction * (touch - insertion);
    stations.push_back({reach * std::cos(position) * outward + Vec3{0.0, reach * std::sin(position), 0.0},
                        across, 4.0, 1.8 + fraction * (depth - 1.8)});
  }
  stations.push_back({apex_reach * outward + Vec3{0.0, apex_y, 0.0}, across, 2.4, 2.4});
  return without(common({tube(std::move(stations)), grown(cavity_shape(), -2.0 * gap)}), bulb_shape(), gap);
}

Distance nerve_shape() {
  constexpr double radius = 2.0;
  return without(tube({{{0.0, bulb_radius - 2.0, 0.0}, {1.0, 0.0, 0.0}, radius, radius},
                       {{0.0, 34.5, 0.0}, {1.0, 0.0, 0.0}, radius, radius}}),
                 bulb_shape(), gap);
}

/// What skin lies on: bulb and bones with the hollow between them filled.
Distance under_skin_shape() {
  return smoothly_united(bulb_shape(), face_shape(), 9.0);
}

Distance skin_shape() {
  const Distance opening = ellipsoid({0.0, -16.0, 0.0}, {14.0, 12.0, 6.5});
  const Distance patch =
      smoothly_common(layer(under_skin_shape(), gap, gap + 4.8), ball({0.0, -8.0, 0.0}, 29.0), 5.0);
  return smoothly_without(patch, opening, 3.0);
}

/// Between bone and skin what no other organ takes. With a `widening` it reaches into these, so that thin
/// layers stay whole, and the channels of slender organs are wider, so that they stay open.
Distance fat_shape(const std::vector<Distance>& slender, double widening) {
  const Distance cavity = cavity_shape();
  // Above the plate, and where it will move.
  const double x = -plate_start.x + 1.2;
  const Distance plate_room = common(
      {box({-x, plate_start.y - 1.2, -40.0}, {x, plate_start.y + plate_cells[1] * plate_cell + 3.0, 0.0}),
       [cavity](const Vec3& p) { return -cavity(p) - (plate_thickness + 2.0 * gap); }});
  Distance fat = common({grown(cavity, 0.8 * widening - gap), grown(under_skin_shape(), widening - gap)});
  fat = without(std::move(fat), bulb_shape(), gap);
  for (const Distance& organ : slender) fat = without(std::move(fat), organ, gap + widening);
  return without(std::move(fat), plate_room);
}

/// Height of the plate's lower side: as far above the floor as organs are apart.
double plate_bottom(const Distance& cavity, double x, double y) {
  double low = -30.0;
  double high = 0.0;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (low + high);
    (cavity({x, y, middle}) > -gap ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// A mesh of a shape; of slender or thin ones that of a shape wider by `widening`, fitted to it.
TetMesh meshed(const Distance& shape, double cell, double widening = 0.0) {
  constexpr double reach = 45.0;
  const StuffingOptions options{{-reach, -reach, -reach}, {reach, reach, reach}, cell};
  return widening > 0.0 ? stuff_fitted(shape, grown(shape, widening), options) : stuff(shape, options);
}

/// The fat, first with wider channels for slender organs.
TetMesh meshed_fat(const std::vector<Distance>& slender, double cell) {
  constexpr double widening = 0.9;
  constexpr double reach = 30.0;
  return stuff_fitted(fat_shape(slender, 0.0), fat_shape(slender, widening),
                      {{-reach, -reach, -reach}, {reach, 1.5 * reach, reach}, cell});
}

}  // namespace

std::vector<Organ> make_eye() {
  const std::vector<std::pair<std::string, double>> recti{{"rectus-lateral", 0.0},
                                                          {"rectus-superior", 90.0},
                                                          {"rectus-medial", 180.0},
                                                          {"rectus-inferior", 270.0}};
  std::vector<Organ> organs{{"bone", meshed(bone_shape(), 7.4, 1.2)}, {"bulb", meshed(bulb_shape(), 5.0)}};
  std::vector<Distance> slender{nerve_shape()};
  for (const auto& [name, angle] : recti) {
    slender.push_back(rectus_shape(angle));
    organs.push_back({name, meshed(slender.back(), 3.2, 0.3)});
  }
  organs.push_back({"nerve", meshed(nerve_shape(), 3.0, 0.3)});
  organs.push_back({"fat", meshed_fat(slender, 4.4)});
  organs.push_back({"skin", meshed(skin_shape(), 5.4, 1.0)});
  const Distance cavity = cavity_shape();
  organs.push_back(
      {"plate", make_plate({.cells = plate_cells,
                            .cell = plate_cell,
                            .thickness = plate_thickness,
                            .start = plate_start,
                            .bottom = [&](double x, double y) { return plate_bottom(cavity, x, y); }})});
  for (Organ& organ : organs) round_points(organ.mesh);
  return organs;
}

}  // namespace palpate::anatomy

#include <utility>
#include <vector>

#include "anatomy/eye_shapes.hpp"
#include "anatomy/fit.hpp"
#include "anatomy/organs.hpp"
#include "anatomy/plate.hpp"
#include "anatomy/round_points.hpp"
#include "anatomy/shapes.hpp"
#include "anatomy/stuffing.hpp"
#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

constexpr double gap = eye_gap;

/// Fat: the space between bone and skin that no other organ fills. With a `widening` it reaches into other
/// organs, so that thin layers stay whole, and the channels of slender organs are wider, so that they stay
/// open.
Distance fat_shape(const std::vector<Distance>& slender, double widening) {
  const Distance cavity = cavity_shape();
  // Leaves room above the plate, and where the plate will move.
  const double x = -eye_plate_start.x + 1.2;
  const Distance plate_room =
      common({box({-x, eye_plate_start.y - 1.2, -40.0},
                  {x, eye_plate_start.y + eye_plate_cells[1] * eye_plate_cell + 3.0, 0.0}),
              [cavity](const Vec3& p) { return -cavity(p) - (eye_plate_thickness + 2.0 * gap); }});
  Distance fat = common({grown(cavity, 0.8 * widening - gap), grown(under_skin_shape(), widening - gap)});
  fat = without(std::move(fat), bulb_shape(), gap);
  for (const Distance& organ : slender) fat = without(std::move(fat), organ, gap + widening);
  return without(std::move(fat), plate_room);
}

/// The mesh of a shape. For slender or thin shapes, meshes the shape widened by `widening` and fits the mesh
/// to the shape.
TetMesh meshed(const Distance& shape, double cell, double widening = 0.0) {
  constexpr double reach = 45.0;
  const StuffingOptions options{{-reach, -reach, -reach}, {reach, reach, reach}, cell};
  return widening > 0.0 ? stuff_fitted(shape, grown(shape, widening), options) : stuff(shape, options);
}

/// The mesh of the fat. Channels for slender organs are made wider first.
TetMesh meshed_fat(const std::vector<Distance>& slender, double cell) {
  constexpr double widening = 0.9;
  constexpr double reach = 30.0;
  return stuff_fitted(fat_shape(slender, 0.0), fat_shape(slender, widening),
                      {{-reach, -reach, -reach}, {reach, 1.5 * reach, reach}, cell});
}

}  // namespace

std::vector<Organ> make_eye() {
  std::vector<Organ> organs{{"bone", meshed(bone_shape(), 7.4, 1.2)}, {"bulb", meshed(bulb_shape(), 5.0)}};
  std::vector<Distance> slender{nerve_shape(gap)};
  for (const auto& [name, angle] : eye_recti) {
    slender.push_back(rectus_shape(angle, gap));
    organs.push_back({name, meshed(slender.back(), 3.2, 0.3)});
  }
  organs.push_back({"nerve", meshed(nerve_shape(gap), 3.0, 0.3)});
  organs.push_back({"fat", meshed_fat(slender, 4.4)});
  organs.push_back({"skin", meshed(skin_shape(gap), 5.4, 1.0)});
  organs.push_back(
      {"plate", make_plate({.cells = eye_plate_cells,
                            .cell = eye_plate_cell,
                            .thickness = eye_plate_thickness,
                            .start = eye_plate_start,
                            .bottom = [](double x, double y) { return over_orbit_floor(x, y, gap); }})});
  for (Organ& organ : organs) round_points(organ.mesh);
  return organs;
}

}  // namespace palpate::anatomy

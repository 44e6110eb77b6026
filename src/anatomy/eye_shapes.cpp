#include "anatomy/eye_shapes.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "anatomy/shapes.hpp"
#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

constexpr double bulb_radius = 12.0;

/// The front of the bones of the face.
Distance face_shape() {
  return ball({0.0, 56.0, 0.0}, 66.0);
}

}  // namespace

Distance bulb_shape() {
  return smoothly_united(ball({}, bulb_radius), ball({0.0, -5.3, 0.0}, 7.8), 1.5);
}

Distance cavity_shape() {
  return smoothly_common(round_cone({0.0, 1.0, 0.0}, {0.0, 34.0, 0.0}, 21.0, 6.5),
                         half_space({0.0, 0.0, -19.2}, {0.0, 0.25, -1.0}), 4.0);
}

Distance bone_shape() {
  const Distance cavity = cavity_shape();
  const Distance wall = common({layer(cavity, -8.0, 7.0), face_shape()});
  const Distance rim = smoothly_common(layer(face_shape(), -7.0, 0.0), ball({0.0, -4.0, 0.0}, 31.0), 6.0);
  return smoothly_without(united({wall, rim}), cavity, 5.0);
}

Distance orbit_bone_shape() {
  const Vec3 middle{-1.0, 10.0, -31.0};
  const Vec3 radii{15.0, 17.0, 14.0};
  constexpr double wall = 2.5;
  const Distance sinus = without(ellipsoid(middle, radii), cavity_shape(), orbit_floor_thickness);
  const Distance maxilla = ellipsoid(middle, {radii.x + wall, radii.y + wall, radii.z + wall});
  return without(without(united({bone_shape(), maxilla}), cavity_shape()), sinus);
}

Distance orbit_floor_shape() {
  return common(
      {layer(cavity_shape(), 0.0, orbit_floor_thickness), box({-16.0, -30.0, -40.0}, {16.0, 26.0, -7.0})});
}

double over_orbit_floor(double x, double y, double above) {
  const Distance cavity = cavity_shape();
  double low = -30.0;
  double high = 0.0;
  constexpr int halvings = 50;
  for (int i = 0; i < halvings; ++i) {
    const double middle = 0.5 * (low + high);
    (cavity({x, y, middle}) > -above ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

Distance rectus_shape(double angle, double gap) {
  constexpr double depth = 2.5;
  const double reach = bulb_radius + gap + depth;
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

Distance nerve_shape(double gap) {
  constexpr double radius = 2.0;
  return without(tube({{{0.0, bulb_radius - 2.0, 0.0}, {1.0, 0.0, 0.0}, radius, radius},
                       {{0.0, 34.5, 0.0}, {1.0, 0.0, 0.0}, radius, radius}}),
                 bulb_shape(), gap);
}

Distance under_skin_shape() {
  return smoothly_united(bulb_shape(), face_shape(), 9.0);
}

Distance skin_shape(double gap) {
  const Distance opening = ellipsoid({0.0, -16.0, 0.0}, {14.0, 12.0, 6.5});
  const Distance patch =
      smoothly_common(layer(under_skin_shape(), gap, gap + 4.8), ball({0.0, -8.0, 0.0}, 29.0), 5.0);
  return smoothly_without(patch, opening, 3.0);
}

}  // namespace palpate::anatomy

#include "io/picture_camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

constexpr double degree = std::numbers::pi / 180.0;
constexpr double view_angle = 26.0 * degree;  // vertical; long lenses keep the shapes of boxes
constexpr double azimuth = -62.0 * degree;
constexpr double elevation = 24.0 * degree;
constexpr double margin = 0.06;  // of the shorter side

void orient(Camera& camera, const Vec3& forward) {
  camera.forward = forward;
  const bool vertical = std::abs(forward.x) + std::abs(forward.y) < 1e-9;
  const Vec3 sky = vertical ? Vec3{0.0, 1.0, 0.0} : Vec3{0.0, 0.0, 1.0};
  camera.right = normalized(cross(forward, sky));
  camera.up = cross(camera.right, forward);
}

Camera lens(int width, int height) {
  Camera camera;
  camera.pixel = 2.0 * std::tan(view_angle / 2.0) / height;
  camera.centre_x = width / 2.0;
  camera.centre_y = height / 2.0;
  return camera;
}

}  // namespace

Vec3 Camera::direction(double x, double y) const {
  return normalized(forward + ((x - centre_x) * pixel) * right + ((centre_y - y) * pixel) * up);
}

ScreenPoint Camera::project(const Vec3& point) const {
  const Vec3 offset = point - position;
  const double depth = dot(offset, forward);
  const double scale = 1.0 / (depth * pixel);
  return {centre_x + dot(offset, right) * scale, centre_y - dot(offset, up) * scale, depth};
}

Camera aim_camera(const Vec3& position, const Vec3& target, int width, int height) {
  Camera camera = lens(width, height);
  orient(camera, normalized(target - position));
  camera.position = position;
  return camera;
}

Camera fit_camera(std::span<const Vec3> points, int width, int height) {
  Camera camera = lens(width, height);
  orient(camera, -1.0 * Vec3{std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation)});
  const double border = margin * std::min(width, height);
  const double slope_x = camera.pixel * (width / 2.0 - border);
  const double slope_y = camera.pixel * (height / 2.0 - border);
  // A camera at (cx, cy, -d) in its own axes sees (x, y, z) left of its right border if x - slope z <= cx +
  // slope d, and so on for the four sides: the extreme points give centre and distance.
  constexpr double lowest = std::numeric_limits<double>::lowest();
  double right = lowest, left = lowest, top = lowest, bottom = lowest, nearest = lowest;
  for (const Vec3& point : points) {
    const double x = dot(point, camera.right);
    const double y = dot(point, camera.up);
    const double z = dot(point, camera.forward);
    right = std::max(right, x - slope_x * z);
    left = std::max(left, -x - slope_x * z);
    top = std::max(top, y - slope_y * z);
    bottom = std::max(bottom, -y - slope_y * z);
    nearest = std::max(nearest, -z);
  }
  const double distance = std::max((right + left) / (2.0 * slope_x), (top + bottom) / (2.0 * slope_y));
  // A single point, or a line along the view, gives a distance of zero.
  const double safe_distance = std::max(distance, nearest + 1e-2);
  camera.position = ((right - left) / 2.0) * camera.right + ((top - bottom) / 2.0) * camera.up -
                    safe_distance * camera.forward;
  return camera;
}

}  // namespace palpate::io

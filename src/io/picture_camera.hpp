#pragma once

#include <span>

#include <palpate/types.hpp>

namespace palpate::io {

/// A position in the image plane, in pixels from the upper left corner, and its depth along the view.
struct ScreenPoint {
  double x = 0.0;
  double y = 0.0;
  double depth = 0.0;
};

/// A pinhole camera over a frame of width x height pixels.
struct Camera {
  Vec3 position;
  Vec3 right;           ///< unit, horizontal
  Vec3 up;              ///< unit
  Vec3 forward;         ///< unit
  double pixel = 0.0;   ///< size of a pixel at depth 1
  double centre_x = 0;  ///< where the view axis meets the image, in pixels
  double centre_y = 0;

  /// Unit direction from the camera through a position in the image.
  [[nodiscard]] Vec3 direction(double x, double y) const;
  /// Where a point appears; meaningless for depth <= 0.
  [[nodiscard]] ScreenPoint project(const Vec3& point) const;
};

/// The camera that looks from `position` to `target`, with z up (y, when it looks along z).
Camera aim_camera(const Vec3& position, const Vec3& target, int width, int height);

/// The nearest camera with a three-quarter view from above that sees all points within the frame minus a
/// margin. Exact: each side of the view pyramid touches its extreme point, or has a wider margin. O(n).
Camera fit_camera(std::span<const Vec3> points, int width, int height);

}  // namespace palpate::io

#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/vector.hpp"
#include "io/picture.hpp"
#include "io/picture_camera.hpp"
#include "io/picture_scene.hpp"

namespace palpate::io {

/// Linear light: red, green, blue.
using Light = Vec3;

/// sRGB in [0, 1] to linear light, and back to 8 bits (IEC 61966-2-1).
Light to_light(const Colour& colour);
std::uint8_t to_byte(double light);

/// A pixel is the mean of samples on a grid.
inline constexpr int samples_per_side = 3;
inline constexpr int samples_of_pixel = samples_per_side * samples_per_side;

/// Computes the colours of an image: surfaces, edges, dots, shadows and background. Everything is in a sphere
/// of radius about 1 around the origin, which gives the scale for offsets and lengths of rays. Holds copies
/// of its data.
class Painter {
 public:
  struct Input {
    std::vector<Vec3> points;         ///< (n_points x 3); only those that triangles use matter
    std::vector<Triangle> triangles;  ///< (n_triangles x 3), at least one
    std::vector<std::array<Light, 3>> corner_colours;  ///< (n_triangles x 3)
    std::vector<std::uint8_t>
        drawn_sides;         ///< (n_triangles) bit i: corner i to the next is an edge; or empty: all are
    std::vector<Vec3> dots;  ///< (n_dots x 3)
    Camera camera;
    int height = 0;  ///< of the image without its caption, pixels
    bool edges = true;
  };
  explicit Painter(Input input);

  /// Light of a pixel. Depends only on its arguments.
  [[nodiscard]] Light pixel(int pixel_x, int pixel_y) const;

 private:
  struct Ray;
  struct Spot;
  struct Pattern;
  using Spots = std::array<Spot, samples_of_pixel>;
  [[nodiscard]] Spot seen(const Ray& ray, const std::optional<RayHit>& meets) const;
  void find_sunlight(Spots& spots, const Pattern& pattern) const;
  void find_skylight(Spots& spots, const Pattern& pattern) const;
  template <class Asks, class Direction>
  void cast(Spots& spots, double Spot::*fraction, double reach, const Asks& asks,
            const Direction& direction) const;
  [[nodiscard]] Light background(const Spot& spot) const;
  [[nodiscard]] Light surface(const Spot& spot) const;
  [[nodiscard]] Light with_dot(const Spot& spot, const RayHit& dot_hit, const Light& behind) const;
  [[nodiscard]] double edge_strength(Index triangle, double x, double y) const;

  Input in_;
  Vec3 to_light_;
  std::array<Vec3, 2> across_light_;  ///< two directions at right angles to the light
  double ground_z_ = 0.0;
  double mean_edge_ = 0.0;
  double few_dots_ = 0.0;    ///< near 1 for few dots, 0 for many: few dots are drawn stronger
  double line_width_ = 0.0;  ///< pixels, on each side of an edge
  std::vector<std::array<Vec3, 3>> normals_;  ///< (n_triangles x 3): of each corner, smooth except at creases
  std::vector<ScreenPoint> screen_;           ///< (n_points): where points appear
  std::vector<double> dot_radii_;             ///< (n_dots)
  RayScene surfaces_;
  std::optional<RayScene> dots_;  ///< empty without dots
};

}  // namespace palpate::io

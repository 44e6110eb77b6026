#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

#include "io/body_colours.hpp"
#include "io/colour_scale.hpp"
#include "io/picture_image.hpp"
#include "parallel/parallel.hpp"

namespace palpate::io {

/// The red of contact points, which have a white rim.
inline constexpr Colour contact_colour{0.82F, 0.06F, 0.10F};

/// Settings of a picture.
struct PictureSettings {
  int width = 1280;            ///< pixels, >= 16
  int height = 960;            ///< pixels, >= 16; the lowest eighteenth is the caption's, if any
  std::optional<Vec3> camera;  ///< none: a three-quarter view from above (z is up) that just holds all bodies
  std::optional<Vec3> target;  ///< where the given camera looks; none: the centre of all bodies
  bool edges = true;           ///< draw the edges of the surface triangles
  std::optional<ColourScale> scale{};  ///< of the subject's values; none: bodies have their own colours
  std::string caption;                 ///< one line at the bottom, ASCII; in a smaller font if it is too wide
};

/// The content of a picture. Spans must outlive it.
struct PictureSubject {
  std::span<const Vec3> positions;        ///< (n_points x 3)
  std::span<const Triangle> triangles;    ///< (n_triangles x 3), counter-clockwise seen from outside
  std::span<const Index> body_of_point;   ///< (n_points)
  std::span<const Index> contact_points;  ///< points drawn as dots; repeated ones are drawn once
  std::span<const Colour> body_colours;   ///< (n_bodies), or empty for default_colour()
  std::span<const double> values{};  ///< (n_points) shown by PictureSettings::scale where they are numbers
  /// (n_triangles) indices of body_colours, instead of the bodies of their points; or empty
  std::span<const Index> colour_of_triangle{};
  std::span<const std::uint8_t>
      edges{};  ///< (n_triangles) sides that are edges, as in CutSurface; empty: all
};

/// Renders a picture by ray casting: needs no display and no graphics card.
///
/// Nine samples a pixel, a soft shadow, and ambient occlusion from a pattern that depends on the pixel alone
/// (with fewer rays where nothing blocks the first sixteen), so that the bytes are the same for every thread
/// count. Contact points are visible through bodies in front of them, fainter with the distance behind the
/// surface. Triangles with a position that is not finite are left out. Throws Error if settings or array
/// lengths do not fit, or if no triangle is left. About O(pixels log n_triangles).
///
/// Not to be called from several threads at once (VTK's fonts are shared).
Image render_picture(const PictureSubject& subject, const PictureSettings& settings,
                     const parallel::Threads& threads);

/// Renders a picture of the surfaces of all bodies at `positions` (n_points x 3) and writes it as PNG, whole
/// or not at all. `contact_points` may be empty, and so may `body_colours` (else n_bodies). Throws as
/// render_picture() and write_png() do.
void render_picture(const std::filesystem::path& path, const Bodies& bodies, std::span<const Vec3> positions,
                    std::span<const Index> contact_points, std::span<const Colour> body_colours,
                    const PictureSettings& settings, const parallel::Threads& threads);

}  // namespace palpate::io

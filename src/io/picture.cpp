#include "io/picture.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "io/picture_camera.hpp"
#include "io/picture_caption.hpp"
#include "io/picture_shading.hpp"

namespace palpate::io {
namespace {

constexpr int tile = 16;  // pixels along a side: the work of one chunk

void expect(bool holds, const std::string& where, const std::string& found, const std::string& expected) {
  if (!holds) throw Error("picture", where, found, expected);
}

void check_length(const std::string& what, std::size_t found, std::size_t expected) {
  expect(found == expected, what, std::to_string(found) + " values", std::to_string(expected));
}

void check(const PictureSubject& subject, const PictureSettings& settings) {
  constexpr int smallest = 16;
  constexpr int largest = 16384;
  for (const auto& [name, size] :
       {std::pair{"width", settings.width}, std::pair{"height", settings.height}}) {
    expect(smallest <= size && size <= largest, name, std::to_string(size), "16 to 16384 pixels");
  }
  check_length("body_of_point", subject.body_of_point.size(), subject.positions.size());
  const auto bodies =
      subject.body_of_point.empty() ? 0 : 1 + *std::ranges::max_element(subject.body_of_point);
  expect(subject.body_colours.empty() || std::cmp_greater_equal(subject.body_colours.size(), bodies),
         "body_colours", std::to_string(subject.body_colours.size()) + " colours", std::to_string(bodies));
  if (!subject.values.empty()) check_length("values", subject.values.size(), subject.positions.size());
  if (!subject.colour_of_triangle.empty()) {
    check_length("colour_of_triangle", subject.colour_of_triangle.size(), subject.triangles.size());
    const Index most = *std::ranges::max_element(subject.colour_of_triangle);
    expect(std::cmp_less(most, subject.body_colours.size()), "colour_of_triangle", std::to_string(most),
           "a number below " + std::to_string(subject.body_colours.size()));
  }
  if (!subject.edges.empty()) check_length("edges", subject.edges.size(), subject.triangles.size());
  expect(!settings.scale || settings.scale->most > settings.scale->least, "scale",
         "a largest value that is not above the smallest", "a larger number");
  for (const Index point : subject.contact_points) {
    expect(point >= 0 && std::cmp_less(point, subject.positions.size()), "contact_points",
           "point " + std::to_string(point), "an index below " + std::to_string(subject.positions.size()));
  }
  if (settings.camera) {
    expect(is_finite(*settings.camera), "camera", "a coordinate that is not finite", "a position");
    expect(settings.camera != settings.target, "camera", "the target itself",
           "a position away from the target");
  }
  expect(!settings.target || is_finite(*settings.target), "target", "a coordinate that is not finite",
         "a position");
}

/// Maps the subject into a sphere of radius 1 around the origin, for all units.
struct Frame {
  Vec3 centre;
  double radius = 1.0;
  [[nodiscard]] Vec3 operator()(const Vec3& point) const { return (1.0 / radius) * (point - centre); }
};

/// The colour of a corner: the colour of its value if it has one, otherwise of its triangle or body.
Light corner_light(const PictureSubject& subject, const PictureSettings& settings, std::size_t triangle,
                   Index point) {
  if (settings.scale && !subject.values.empty() && std::isfinite(at(subject.values, point)))
    return to_light(scale_colour(at(subject.values, point), *settings.scale));
  const Index body = subject.colour_of_triangle.empty() ? at(subject.body_of_point, point)
                                                        : subject.colour_of_triangle[triangle];
  return to_light(subject.body_colours.empty() ? default_colour(body) : at(subject.body_colours, body));
}

void add_visible_triangles(const PictureSubject& subject, const PictureSettings& settings,
                           Painter::Input& input) {
  for (std::size_t i = 0; i < subject.triangles.size(); ++i) {
    const Triangle& t = subject.triangles[i];
    if (!std::ranges::all_of(t, [&](Index corner) { return is_finite(at(subject.positions, corner)); }))
      continue;
    input.triangles.push_back(t);
    input.corner_colours.push_back({corner_light(subject, settings, i, t[0]),
                                    corner_light(subject, settings, i, t[1]),
                                    corner_light(subject, settings, i, t[2])});
    if (!subject.edges.empty()) input.drawn_sides.push_back(subject.edges[i]);
  }
  expect(!input.triangles.empty(), "triangles", "no triangle with finite positions", "one or more");
}

Frame frame_of(std::span<const Vec3> positions, std::span<const Triangle> triangles) {
  constexpr double huge = std::numeric_limits<double>::max();
  Vec3 low{huge, huge, huge};
  Vec3 high = -low;
  for (const Triangle& t : triangles) {
    for (const Index corner : t) {
      const Vec3& p = at(positions, corner);
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  }
  const double radius = 0.5 * length(high - low);
  expect(std::isfinite(radius), "positions", "bounds beyond double precision", "positions in range");
  return {0.5 * (low + high), radius > 0.0 ? radius : 1.0};
}

Camera camera_of(const PictureSettings& settings, const Frame& frame, std::span<const Vec3> points,
                 std::span<const Triangle> triangles, int height) {
  if (settings.camera) {
    const Vec3 target = settings.target ? frame(*settings.target) : Vec3{};
    const Vec3 camera = frame(*settings.camera);
    expect(camera != target, "camera", "the target itself", "a position away from the target");
    return aim_camera(camera, target, settings.width, height);
  }
  std::vector<Vec3> used;
  used.reserve(3 * triangles.size());
  for (const Triangle& t : triangles) {
    for (const Index corner : t) used.push_back(at(points, corner));
  }
  return fit_camera(used, settings.width, height);
}

Painter painter_of(const PictureSubject& subject, const PictureSettings& settings, int height) {
  Painter::Input input;
  add_visible_triangles(subject, settings, input);
  const Frame frame = frame_of(subject.positions, input.triangles);
  for (const Vec3& p : subject.positions) input.points.push_back(is_finite(p) ? frame(p) : Vec3{});
  std::vector<Index> dots(subject.contact_points.begin(), subject.contact_points.end());
  std::ranges::sort(dots);
  const auto repeated = std::ranges::unique(dots);
  dots.erase(repeated.begin(), repeated.end());
  for (const Index point : dots) {
    if (is_finite(at(subject.positions, point))) input.dots.push_back(at(input.points, point));
  }
  input.camera = camera_of(settings, frame, input.points, input.triangles, height);
  input.height = height;
  input.edges = settings.edges;
  return Painter(std::move(input));
}

void paint_tile(const Painter& painter, int left, int top, int height, Image& image) {
  for (int y = top; y < std::min(top + tile, height); ++y) {
    for (int x = left; x < std::min(left + tile, image.width); ++x) {
      const Light light = painter.pixel(x, y);
      std::uint8_t* pixel = image.pixel(x, y);
      pixel[0] = to_byte(light.x);
      pixel[1] = to_byte(light.y);
      pixel[2] = to_byte(light.z);
    }
  }
}

}  // namespace

Image render_picture(const PictureSubject& subject, const PictureSettings& settings,
                     const parallel::Threads& threads) {
  check(subject, settings);
  Image image(settings.width, settings.height);
  std::ranges::fill(image.bytes, std::uint8_t{255});
  const int height = settings.height - caption_height(settings.caption, settings.height);
  const Painter painter = painter_of(subject, settings, height);
  const int columns = (settings.width + tile - 1) / tile;
  const int rows = (height + tile - 1) / tile;
  parallel::for_each(threads, static_cast<std::size_t>(columns * rows), 1, [&](std::size_t i) {
    const int index = static_cast<int>(i);
    paint_tile(painter, index % columns * tile, index / columns * tile, height, image);
  });
  if (settings.scale) draw_scale(image, *settings.scale, settings.height - height);
  draw_caption(image, settings.caption);
  return image;
}

void render_picture(const std::filesystem::path& path, const Bodies& bodies, std::span<const Vec3> positions,
                    std::span<const Index> contact_points, std::span<const Colour> body_colours,
                    const PictureSettings& settings, const parallel::Threads& threads) {
  check_length("positions", positions.size(), bodies.points_rest().size());
  write_png(path, render_picture({.positions = positions,
                                  .triangles = bodies.triangles(),
                                  .body_of_point = bodies.body_of_point(),
                                  .contact_points = contact_points,
                                  .body_colours = body_colours},
                                 settings, threads));
}

}  // namespace palpate::io

#include "io/picture_shading.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "io/picture_normals.hpp"

namespace palpate::io {
namespace {

constexpr double offset = 1e-4;           // secondary rays start this far above a surface
constexpr double occlusion_reach = 0.45;  // distance within which surfaces darken a corner
constexpr int occlusion_rays = 4;         // rays per sample
constexpr int sun_rays = 4;               // rays per sample; with fewer, soft edges of shadows are speckled
constexpr double sun_size = 0.10;         // radius of the light as a slope: how soft shadows are
constexpr double sun = 0.80;
constexpr double sky = 0.47;
constexpr double bounce = 0.32;               // light from below
constexpr double dot_pixels = 3.4 / 960.0;    // radius of a dot, of the image's height
constexpr double line_pixels = 0.62 / 960.0;  // half width of an edge line, of the image's height

double smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Light mix(const Light& a, const Light& b, double weight) {
  return (1.0 - weight) * a + weight * b;
}

/// A counter-based hash (the finalizer of SplitMix64), in [0, 1).
double random_of(std::uint64_t counter) {
  counter += 0x9e3779b97f4a7c15U;
  counter = (counter ^ (counter >> 30U)) * 0xbf58476d1ce4e5b9U;
  counter = (counter ^ (counter >> 27U)) * 0x94d049bb133111ebU;
  counter ^= counter >> 31U;
  return static_cast<double>(counter >> 11U) * 0x1p-53;
}

double fraction(double x) {
  return x - std::floor(x);
}

double mean_edge_length(std::span<const Vec3> points, std::span<const Triangle> triangles) {
  double sum = 0.0;
  for (const Triangle& t : triangles) {
    for (int i = 0; i < 3; ++i) sum += length(at(points, at(t, (i + 1) % 3)) - at(points, at(t, i)));
  }
  constexpr double smallest =
      1e-9;  // triangles without area are never hit, but must not cause a division by zero
  return std::max(smallest, sum / (3.0 * static_cast<double>(triangles.size())));
}

/// A number in [0, 1) for each pixel, evenly distributed over neighbouring pixels, so that noise is
/// fine-grained (interleaved gradient noise, Jimenez 2014).
double pixel_noise(double x, double y) {
  return fraction(52.9829189 * fraction(0.06711056 * x + 0.00583715 * y));
}

/// Distance in the image from (x, y) to the line through two points.
double line_distance(const ScreenPoint& a, const ScreenPoint& b, double x, double y) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double span = std::hypot(dx, dy);
  return span > 0.0 ? std::abs(dx * (y - a.y) - dy * (x - a.x)) / span : 0.0;
}

}  // namespace

struct Painter::Ray {
  Vec3 origin;
  Vec3 direction;
  double x, y;  // where the ray meets the image
};

/// The random choices of one sample: a low-discrepancy sequence (R2, Roberts 2018) with an own offset in each
/// pixel.
struct Painter::Pattern {
  double offset_u, offset_v;
  int sample;
  [[nodiscard]] std::pair<double, double> at(int ray, int rays) const {
    const double n = sample * rays + ray + 1;
    return {fraction(offset_u + n * 0.7548776662466927), fraction(offset_v + n * 0.5698402909980532)};
  }
};

Light to_light(const Colour& colour) {
  const auto linear = [](float c) { return c <= 0.04045F ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4); };
  return {linear(colour[0]), linear(colour[1]), linear(colour[2])};
}

std::uint8_t to_byte(double light) {
  const double c = std::clamp(light, 0.0, 1.0);
  const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255.0 * encoded));
}

Painter::Painter(Input input)
    : in_(std::move(input)),
      mean_edge_(mean_edge_length(in_.points, in_.triangles)),
      few_dots_(100.0 / (100.0 + static_cast<double>(in_.dots.size()))),
      line_width_(std::max(0.5, line_pixels * in_.height)),
      normals_(corner_normals(in_.points, in_.triangles)),
      surfaces_(RayScene::of_triangles(in_.points, in_.triangles)) {
  const Camera& camera = in_.camera;
  to_light_ = normalized(-0.45 * camera.right + Vec3{0.0, 0.0, 1.0} - 0.45 * camera.forward);
  ground_z_ = std::numeric_limits<double>::max();
  for (const Triangle& t : in_.triangles) {
    for (const Index corner : t) ground_z_ = std::min(ground_z_, at(in_.points, corner).z);
  }
  ground_z_ -= 10.0 * offset;
  screen_.reserve(in_.points.size());
  for (const Vec3& point : in_.points) screen_.push_back(camera.project(point));
  for (const Vec3& dot_centre : in_.dots) {
    const double depth = camera.project(dot_centre).depth;
    dot_radii_.push_back(std::max(2.0, dot_pixels * (1.0 + 0.5 * few_dots_) * in_.height) * camera.pixel *
                         std::max(depth, 0.0));
  }
  if (!in_.dots.empty()) dots_ = RayScene::of_spheres(in_.dots, dot_radii_);
}

Light Painter::sample(int pixel_x, int pixel_y, int index) const {
  const int column = index % samples_per_side;
  const int row = index / samples_per_side;
  const double x = pixel_x + (column + 0.5) / samples_per_side;
  const double y = pixel_y + (row + 0.5) / samples_per_side;
  const Ray ray{in_.camera.position, in_.camera.direction(x, y), x, y};
  const Pattern pattern{
      pixel_noise(pixel_x, pixel_y),
      random_of(static_cast<std::uint64_t>(pixel_y) << 32U | static_cast<std::uint64_t>(pixel_x)), index};

  const std::optional<RayHit> hit = surfaces_.first_hit(ray.origin, ray.direction);
  const Light light = hit ? surface(*hit, ray, pattern) : background(ray, pattern);
  if (!dots_) return light;
  const std::optional<RayHit> dot_hit = dots_->first_hit(ray.origin, ray.direction);
  if (!dot_hit) return light;
  return with_dot(light, *dot_hit, hit ? hit->distance : std::numeric_limits<double>::infinity(), ray);
}

/// White below, a slight blue above, and the shadow of the bodies on an invisible ground.
Light Painter::background(const Ray& ray, const Pattern& pattern) const {
  const Light top{0.84, 0.88, 0.93};
  const Light paper = mix(top, {1.0, 1.0, 1.0}, smooth_step(0.0, 0.75, ray.y / in_.height));
  if (ray.direction.z > -1e-6 || ray.origin.z <= ground_z_) return paper;
  const double distance = (ground_z_ - ray.origin.z) / ray.direction.z;
  const Vec3 place = ray.origin + distance * ray.direction;
  const double fade = (1.0 - smooth_step(1.1, 2.4, std::hypot(place.x, place.y))) *
                      smooth_step(0.0, 0.06, 1.0 - ray.y / in_.height);
  if (fade <= 0.0) return paper;
  const double open = openness(place, {0.0, 0.0, 1.0}, pattern);
  const double shadow = 0.30 * (1.0 - lit(place, pattern)) + 0.38 * (1.0 - open);
  return (1.0 - fade * shadow) * paper;
}

Light Painter::surface(const RayHit& hit, const Ray& ray, const Pattern& pattern) const {
  const Triangle& t = at(in_.triangles, hit.primitive);
  const auto corner = [&](int i) { return at(in_.points, at(t, i)); };
  Vec3 flat = normalized(cross(corner(1) - corner(0), corner(2) - corner(0)));
  const auto& n = at(normals_, hit.primitive);
  Vec3 smooth = normalized((1.0 - hit.u - hit.v) * n[0] + hit.u * n[1] + hit.v * n[2]);
  if (dot(flat, ray.direction) > 0.0) {  // the surface is seen from inside
    flat = -flat;
    smooth = -smooth;
  }
  const Vec3 place = ray.origin + hit.distance * ray.direction + offset * flat;
  const double facing = std::max(0.0, dot(smooth, to_light_));
  const double direct = facing > 0.0 ? facing * lit(place, pattern) : 0.0;
  const double ambient = (bounce + (sky - bounce) * (0.5 + 0.5 * smooth.z)) * openness(place, flat, pattern);
  const auto& corners = at(in_.corner_colours, hit.primitive);
  const Light colour = (1.0 - hit.u - hit.v) * corners[0] + hit.u * corners[1] + hit.v * corners[2];
  const Light light = (sun * direct + ambient) * colour;
  if (!in_.edges) return light;
  return mix(light, (0.18 * (sun * direct + ambient)) * colour,
             0.75 * edge_strength(hit.primitive, ray.x, ray.y));
}

/// 1 on the edge of a triangle, 0 away from it; fades where triangles are too small for lines.
double Painter::edge_strength(Index triangle, double x, double y) const {
  const Triangle& t = at(in_.triangles, triangle);
  const ScreenPoint& a = at(screen_, t[0]);
  const ScreenPoint& b = at(screen_, t[1]);
  const ScreenPoint& c = at(screen_, t[2]);
  if (std::min({a.depth, b.depth, c.depth}) <= 0.0) return 0.0;
  const double area = std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  const double longest = std::max(
      {std::hypot(b.x - a.x, b.y - a.y), std::hypot(c.x - b.x, c.y - b.y), std::hypot(a.x - c.x, a.y - c.y)});
  const double height = longest > 0.0 ? area / longest : 0.0;
  const unsigned sides = in_.drawn_sides.empty() ? 7U : at(in_.drawn_sides, triangle);
  double distance = std::numeric_limits<double>::infinity();
  if ((sides & 1U) != 0) distance = std::min(distance, line_distance(a, b, x, y));
  if ((sides & 2U) != 0) distance = std::min(distance, line_distance(b, c, x, y));
  if ((sides & 4U) != 0) distance = std::min(distance, line_distance(c, a, x, y));
  return (1.0 - smooth_step(line_width_ - 0.25, line_width_ + 0.25, distance)) *
         smooth_step(2.0 * line_width_, 12.0 * line_width_, height);
}

/// A red disc with a white rim: opaque at the surface, fainter with its depth in edge lengths.
Light Painter::with_dot(const Light& behind, const RayHit& dot_hit, double surface_distance,
                        const Ray& ray) const {
  const Vec3 to_centre = at(in_.dots, dot_hit.primitive) - ray.origin;
  const double along = dot(to_centre, ray.direction);
  const double across = std::sqrt(std::max(0.0, squared_length(to_centre) - along * along));
  const double hidden = std::max(0.0, along - surface_distance) / mean_edge_;
  const double strength = 1.0 - (0.88 - 0.40 * few_dots_) * smooth_step(0.3, 2.5, hidden);
  const bool core = across < 0.70 * at(dot_radii_, dot_hit.primitive);
  return mix(behind, core ? to_light(contact_colour) : Light{1.0, 1.0, 1.0}, strength * (core ? 1.0 : 0.85));
}

/// Fraction of the half space above a position without near surfaces, weighted by the cosine (ambient
/// occlusion).
double Painter::openness(const Vec3& place, const Vec3& normal, const Pattern& pattern) const {
  const Vec3 helper = std::abs(normal.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  const Vec3 side = normalized(cross(normal, helper));
  const Vec3 other = cross(normal, side);
  int open = 0;
  for (int ray = 0; ray < occlusion_rays; ++ray) {
    const auto [u, v] = pattern.at(ray, occlusion_rays);
    const double radius = std::sqrt(u);
    const double angle = 2.0 * std::numbers::pi * v;
    const Vec3 direction = (radius * std::cos(angle)) * side + (radius * std::sin(angle)) * other +
                           std::sqrt(std::max(0.0, 1.0 - u)) * normal;
    if (!surfaces_.blocked(place, direction, occlusion_reach)) ++open;
  }
  return static_cast<double>(open) / occlusion_rays;
}

/// The fraction of the light that reaches a position: soft shadows.
double Painter::lit(const Vec3& place, const Pattern& pattern) const {
  const Vec3 side = normalized(cross(to_light_, in_.camera.forward));
  const Vec3 other = cross(to_light_, side);
  int open = 0;
  for (int ray = 0; ray < sun_rays; ++ray) {
    const auto [u, v] = pattern.at(ray, sun_rays);
    const double radius = sun_size * std::sqrt(v);
    const double angle = 2.0 * std::numbers::pi * u;
    const Vec3 direction = to_light_ + (radius * std::cos(angle)) * side + (radius * std::sin(angle)) * other;
    if (!surfaces_.blocked(place, normalized(direction), 8.0)) ++open;
  }
  return static_cast<double>(open) / sun_rays;
}

}  // namespace palpate::io

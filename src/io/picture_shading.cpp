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
constexpr double sun_reach = 8.0;
// Of the light, and as many of the sky; with fewer, soft edges of shadows are speckled.
constexpr int rays_of_sample = 4;
constexpr double sun_size = 0.10;  // radius of the light as a slope: how soft shadows are
constexpr double sun = 0.80;
constexpr double sky = 0.47;
constexpr double bounce = 0.32;             // light from below
constexpr double dot_pixels = 3.4 / 960.0;  // radius of a dot, of the image's height
constexpr double full_turn = 2.0 * std::numbers::pi;
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
  const double span = std::sqrt(dx * dx + dy * dy);
  return span > 0.0 ? std::abs(dx * (y - a.y) - dy * (x - a.x)) / span : 0.0;
}

}  // namespace

struct Painter::Ray {
  Vec3 origin;
  Vec3 direction;
  double x, y;  // where the ray meets the image
};

/// What one sample of a pixel sees.
struct Painter::Spot {
  Ray ray;
  std::optional<RayHit> hit;  ///< none: background
  Vec3 place;                 ///< secondary rays start here
  Vec3 normal;                ///< of the side that is seen
  Vec3 side;                  ///< at a right angle to the normal
  Vec3 smooth;                ///< the same between the normals of corners
  double facing = 0.0;        ///< cosine of the angle to the light; 0: no light
  double shadow = 0.0;        ///< background: strength of shadows on the ground
  double lit = 0.0;           ///< fraction of the light that is not blocked: soft shadows
  double open = 0.0;  ///< fraction of the half space without near surfaces, weighted by the cosine (ambient
                      ///< occlusion)
};

/// The random choices of a pixel: a low-discrepancy sequence (R2, Roberts 2018) that starts at (u, v).
struct Painter::Pattern {
  double u, v;
  double cos_u, sin_u, cos_v, sin_v;  ///< of 2 pi u and 2 pi v
  Pattern(double start_u, double start_v)
      : u(start_u),
        v(start_v),
        cos_u(std::cos(full_turn * u)),
        sin_u(std::sin(full_turn * u)),
        cos_v(std::cos(full_turn * v)),
        sin_v(std::sin(full_turn * v)) {}
};

namespace {

/// Item n of the sequence that starts at (0, 0), n = 1, 2 ...
struct SequenceItem {
  explicit SequenceItem(int n)
      : u(fraction(n * 0.7548776662466927)),
        v(fraction(n * 0.5698402909980532)),
        cos_u(std::cos(full_turn * u)),
        sin_u(std::sin(full_turn * u)),
        cos_v(std::cos(full_turn * v)),
        sin_v(std::sin(full_turn * v)) {}
  double u, v;
  double cos_u, sin_u, cos_v, sin_v;
};

/// An item for each ray of each sample.
const std::vector<SequenceItem>& sequence() {
  static const std::vector<SequenceItem> items = [] {
    std::vector<SequenceItem> all;
    for (int n = 1; n <= samples_of_pixel * rays_of_sample; ++n) all.emplace_back(n);
    return all;
  }();
  return items;
}

}  // namespace

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
  across_light_[0] = normalized(cross(to_light_, camera.forward));
  across_light_[1] = cross(to_light_, across_light_[0]);
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

Light Painter::pixel(int pixel_x, int pixel_y) const {
  const Pattern pattern(pixel_noise(pixel_x, pixel_y), random_of(static_cast<std::uint64_t>(pixel_y) << 32U |
                                                                 static_cast<std::uint64_t>(pixel_x)));
  std::array<Ray, samples_of_pixel> rays;
  Rays to_surfaces;
  for (int i = 0; i < samples_of_pixel; ++i) {
    const int column = i % samples_per_side;
    const int row = i / samples_per_side;
    const double x = pixel_x + (column + 0.5) / samples_per_side;
    const double y = pixel_y + (row + 0.5) / samples_per_side;
    rays[static_cast<std::size_t>(i)] = {in_.camera.position, in_.camera.direction(x, y), x, y};
    to_surfaces.add(in_.camera.position, rays[static_cast<std::size_t>(i)].direction);
  }
  const auto hits = surfaces_.first_hits(to_surfaces);
  Spots spots;
  for (std::size_t i = 0; i < spots.size(); ++i) spots[i] = seen(rays[i], hits[i]);
  find_sunlight(spots, pattern);
  find_skylight(spots, pattern);
  const auto dots = dots_ ? dots_->first_hits(to_surfaces) : decltype(hits){};
  Light sum{};
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const Light light = spots[i].hit ? surface(spots[i]) : background(spots[i]);
    sum += dots[i] ? with_dot(spots[i], *dots[i], light) : light;
  }
  return (1.0 / samples_of_pixel) * sum;
}

/// What a ray from the camera meets, without the light that reaches it.
Painter::Spot Painter::seen(const Ray& ray, const std::optional<RayHit>& meets) const {
  Spot spot{.ray = ray,
            .hit = meets,
            .place = {},
            .normal = {0.0, 0.0, 1.0},
            .side = {1.0, 0.0, 0.0},
            .smooth = {}};
  if (!spot.hit) {
    if (ray.direction.z > -1e-6 || ray.origin.z <= ground_z_) return spot;
    spot.place = ray.origin + ((ground_z_ - ray.origin.z) / ray.direction.z) * ray.direction;
    spot.shadow =
        (1.0 - smooth_step(1.1, 2.4, std::sqrt(spot.place.x * spot.place.x + spot.place.y * spot.place.y))) *
        smooth_step(0.0, 0.06, 1.0 - ray.y / in_.height);
    return spot;
  }
  const RayHit& hit = *spot.hit;
  const Triangle& t = at(in_.triangles, hit.primitive);
  const auto corner = [&](int i) { return at(in_.points, at(t, i)); };
  spot.normal = normalized(cross(corner(1) - corner(0), corner(2) - corner(0)));
  const auto& n = at(normals_, hit.primitive);
  spot.smooth = normalized((1.0 - hit.u - hit.v) * n[0] + hit.u * n[1] + hit.v * n[2]);
  if (dot(spot.normal, ray.direction) > 0.0) {  // the surface is seen from inside
    spot.normal = -spot.normal;
    spot.smooth = -spot.smooth;
  }
  spot.side = normalized(
      cross(spot.normal, std::abs(spot.normal.x) < 0.5 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0}));
  spot.place = ray.origin + hit.distance * ray.direction + offset * spot.normal;
  spot.facing = std::max(0.0, dot(spot.smooth, to_light_));
  return spot;
}

/// White below, a slight blue above, and the shadow of the bodies on an invisible ground.
Light Painter::background(const Spot& spot) const {
  const Light top{0.84, 0.88, 0.93};
  const Light paper = mix(top, {1.0, 1.0, 1.0}, smooth_step(0.0, 0.75, spot.ray.y / in_.height));
  return (1.0 - spot.shadow * (0.30 * (1.0 - spot.lit) + 0.38 * (1.0 - spot.open))) * paper;
}

Light Painter::surface(const Spot& spot) const {
  const RayHit& hit = *spot.hit;
  const double ambient = (bounce + (sky - bounce) * (0.5 + 0.5 * spot.smooth.z)) * spot.open;
  const double light = sun * spot.facing * spot.lit + ambient;
  const auto& corners = at(in_.corner_colours, hit.primitive);
  const Light colour = light * ((1.0 - hit.u - hit.v) * corners[0] + hit.u * corners[1] + hit.v * corners[2]);
  if (!in_.edges) return colour;
  return mix(colour, 0.18 * colour, 0.75 * edge_strength(hit.primitive, spot.ray.x, spot.ray.y));
}

/// 1 on the edge of a triangle, 0 away from it; fades where triangles are too small for lines.
double Painter::edge_strength(Index triangle, double x, double y) const {
  const Triangle& t = at(in_.triangles, triangle);
  const ScreenPoint& a = at(screen_, t[0]);
  const ScreenPoint& b = at(screen_, t[1]);
  const ScreenPoint& c = at(screen_, t[2]);
  if (std::min({a.depth, b.depth, c.depth}) <= 0.0) return 0.0;
  const double area = std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  const auto square = [](const ScreenPoint& p, const ScreenPoint& q) {
    return (q.x - p.x) * (q.x - p.x) + (q.y - p.y) * (q.y - p.y);
  };
  const double longest = std::sqrt(std::max({square(a, b), square(b, c), square(c, a)}));
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
Light Painter::with_dot(const Spot& spot, const RayHit& dot_hit, const Light& behind) const {
  const Ray& ray = spot.ray;
  const double surface_distance = spot.hit ? spot.hit->distance : std::numeric_limits<double>::infinity();
  const Vec3 to_centre = at(in_.dots, dot_hit.primitive) - ray.origin;
  const double along = dot(to_centre, ray.direction);
  const double across = std::sqrt(std::max(0.0, squared_length(to_centre) - along * along));
  const double hidden = std::max(0.0, along - surface_distance) / mean_edge_;
  const double strength = 1.0 - (0.88 - 0.40 * few_dots_) * smooth_step(0.3, 2.5, hidden);
  const bool core = across < 0.70 * at(dot_radii_, dot_hit.primitive);
  return mix(behind, core ? to_light(contact_colour) : Light{1.0, 1.0, 1.0}, strength * (core ? 1.0 : 0.85));
}

/// Sets `fraction` of the spots that ask for it to the fraction of their rays that no surface blocks. If none
/// of the first packet of rays is blocked, no others are cast.
template <class Asks, class Direction>
void Painter::cast(Spots& spots, double Spot::*fraction, double reach, const Asks& asks,
                   const Direction& direction) const {
  std::array<int, samples_of_pixel> rays_of_spot{};
  std::array<std::size_t, Rays::most> spot_of_ray{};
  Rays rays;
  const auto cast_packet = [&] {  // returns the number of rays that are not blocked
    const auto blocked = surfaces_.blocked(rays, reach);
    for (std::size_t i = 0; i < rays.count; ++i) {
      spots[spot_of_ray[i]].*fraction += blocked[i] ? 0.0 : 1.0;
      ++rays_of_spot[spot_of_ray[i]];
    }
    return std::count(blocked.begin(), blocked.begin() + static_cast<std::ptrdiff_t>(rays.count), false);
  };
  const auto& items = sequence();
  bool first = true;
  for (std::size_t k = 0; k <= items.size(); ++k) {
    if (rays.count == Rays::most || (k == items.size() && rays.count > 0)) {
      const auto open = cast_packet();
      if (first && std::cmp_equal(open, rays.count)) break;
      first = false;
      rays.count = 0;
    }
    if (k == items.size() || !asks(spots[k % spots.size()])) continue;
    spot_of_ray[rays.count] = k % spots.size();
    rays.add(spots[k % spots.size()].place, direction(spots[k % spots.size()], items[k]));
  }
  for (std::size_t i = 0; i < spots.size(); ++i) spots[i].*fraction /= std::max(1, rays_of_spot[i]);
}

void Painter::find_sunlight(Spots& spots, const Pattern& pattern) const {
  cast(
      spots, &Spot::lit, sun_reach, [](const Spot& spot) { return spot.facing > 0.0 || spot.shadow > 0.0; },
      [&](const Spot&, const SequenceItem& item) {
        const double radius = sun_size * std::sqrt(fraction(pattern.v + item.v));
        return to_light_ +
               (radius * (pattern.cos_u * item.cos_u - pattern.sin_u * item.sin_u)) * across_light_[0] +
               (radius * (pattern.sin_u * item.cos_u + pattern.cos_u * item.sin_u)) * across_light_[1];
      });
}

void Painter::find_skylight(Spots& spots, const Pattern& pattern) const {
  cast(
      spots, &Spot::open, occlusion_reach, [](const Spot& spot) { return spot.hit || spot.shadow > 0.0; },
      [&](const Spot& spot, const SequenceItem& item) {
        const double u = fraction(pattern.u + item.u);
        const double radius = std::sqrt(u);
        return (radius * (pattern.cos_v * item.cos_v - pattern.sin_v * item.sin_v)) * spot.side +
               (radius * (pattern.sin_v * item.cos_v + pattern.cos_v * item.sin_v)) *
                   cross(spot.normal, spot.side) +
               std::sqrt(std::max(0.0, 1.0 - u)) * spot.normal;
      });
}

}  // namespace palpate::io

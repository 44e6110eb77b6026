#include "anatomy/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/vector.hpp"

namespace palpate::anatomy {
namespace {

/// ((x/a)^2 + (y/b)^2 + (z/c)^2)^(1/2) - 1, divided by the length of its gradient.
double ellipsoid_distance(const Vec3& p, const Vec3& r) {
  const Vec3 scaled{p.x / r.x, p.y / r.y, p.z / r.z};
  const Vec3 twice{scaled.x / r.x, scaled.y / r.y, scaled.z / r.z};
  const double k0 = length(scaled);
  const double k1 = length(twice);
  return k1 > 0.0 ? k0 * (k0 - 1.0) / k1 : -std::min({r.x, r.y, r.z});
}

double smallest_value(const std::vector<Distance>& shapes, const Vec3& p) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Distance& shape : shapes) smallest = std::min(smallest, shape(p));
  return smallest;
}

/// The smooth minimum (polynomial, quadratic) of two distances.
double smooth_minimum(double a, double b, double radius) {
  const double overlap = std::max(radius - std::abs(a - b), 0.0) / radius;
  return std::min(a, b) - 0.25 * overlap * overlap * radius;
}

Vec3 blend(const Vec3& a, const Vec3& b, double fraction) {
  return a + fraction * (b - a);
}

/// Distance to the part of a tube between two stations.
double segment_distance(const TubeStation& from, const TubeStation& to, const Vec3& p) {
  const Vec3 axis = to.center - from.center;
  const double fraction = std::clamp(dot(p - from.center, axis) / squared_length(axis), 0.0, 1.0);
  const double width = from.width + fraction * (to.width - from.width);
  const double depth = from.depth + fraction * (to.depth - from.depth);
  const Vec3 along = normalized(axis);
  const Vec3 first = blend(from.across, to.across, fraction);
  const Vec3 across = normalized(first - dot(first, along) * along);
  const Vec3 other = cross(along, across);
  const Vec3 offset = p - blend(from.center, to.center, fraction);
  return ellipsoid_distance({dot(offset, across), dot(offset, other), dot(offset, along)},
                            {width, depth, std::min(width, depth)});
}

}  // namespace

Distance ball(const Vec3& center, double radius) {
  return [=](const Vec3& p) { return length(p - center) - radius; };
}

Distance ellipsoid(const Vec3& center, const Vec3& radii) {
  return [=](const Vec3& p) { return ellipsoid_distance(p - center, radii); };
}

Distance round_cone(const Vec3& a, const Vec3& b, double radius_a, double radius_b) {
  const double reach = length(b - a);
  const Vec3 axis = normalized(b - a);
  const double sine = (radius_a - radius_b) / reach;
  const double cosine = std::sqrt(1.0 - sine * sine);
  return [=](const Vec3& p) {
    const double along = dot(p - a, axis);
    const double across = length(p - a - along * axis);
    const double side = cosine * along - sine * across;
    if (side < 0.0) return length(p - a) - radius_a;
    if (side > cosine * reach) return length(p - b) - radius_b;
    return cosine * across + sine * along - radius_a;
  };
}

Distance half_space(const Vec3& point, const Vec3& normal) {
  return [=, unit = normalized(normal)](const Vec3& p) { return dot(p - point, unit); };
}

Distance box(const Vec3& lower, const Vec3& upper) {
  const Vec3 center = 0.5 * (lower + upper);
  const Vec3 half = 0.5 * (upper - lower);
  return [=](const Vec3& p) {
    const Vec3 d = p - center;
    const Vec3 q{std::abs(d.x) - half.x, std::abs(d.y) - half.y, std::abs(d.z) - half.z};
    const Vec3 outside{std::max(q.x, 0.0), std::max(q.y, 0.0), std::max(q.z, 0.0)};
    return length(outside) + std::min(std::max({q.x, q.y, q.z}), 0.0);
  };
}

Distance tube(std::vector<TubeStation> stations) {
  return [stations = std::move(stations)](const Vec3& p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < stations.size(); ++i)
      nearest = std::min(nearest, segment_distance(stations[i - 1], stations[i], p));
    return nearest;
  };
}

Distance grown(Distance shape, double distance) {
  return [shape = std::move(shape), distance](const Vec3& p) { return shape(p) - distance; };
}

Distance layer(Distance shape, double inner, double outer) {
  return [shape = std::move(shape), inner, outer](const Vec3& p) {
    const double d = shape(p);
    return std::max(d - outer, inner - d);
  };
}

Distance united(std::vector<Distance> shapes) {
  return [shapes = std::move(shapes)](const Vec3& p) { return smallest_value(shapes, p); };
}

Distance common(std::vector<Distance> shapes) {
  return [shapes = std::move(shapes)](const Vec3& p) {
    double largest = -std::numeric_limits<double>::infinity();
    for (const Distance& shape : shapes) largest = std::max(largest, shape(p));
    return largest;
  };
}

Distance smoothly_united(Distance a, Distance b, double radius) {
  return [a = std::move(a), b = std::move(b), radius](const Vec3& p) {
    return smooth_minimum(a(p), b(p), radius);
  };
}

Distance smoothly_common(Distance a, Distance b, double radius) {
  return [a = std::move(a), b = std::move(b), radius](const Vec3& p) {
    return -smooth_minimum(-a(p), -b(p), radius);
  };
}

Distance smoothly_without(Distance shape, Distance other, double radius) {
  return [shape = std::move(shape), other = std::move(other), radius](const Vec3& p) {
    return -smooth_minimum(-shape(p), other(p), radius);
  };
}

Distance without(Distance shape, Distance other, double gap) {
  return [shape = std::move(shape), other = std::move(other), gap](const Vec3& p) {
    return std::max(shape(p), gap - other(p));
  };
}

}  // namespace palpate::anatomy

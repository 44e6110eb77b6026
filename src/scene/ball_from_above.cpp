#include "scene/ball_from_above.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/vector.hpp"

namespace palpate {
namespace {

double longest_edge(const Vec3& a, const Vec3& b, const Vec3& c) {
  return std::max({length(b - a), length(c - b), length(a - c)});
}

}  // namespace

std::vector<Vec3> surface_samples(const Bodies& bodies, double spacing) {
  constexpr int most = 50;  // samples along an edge
  std::vector<Vec3> samples;
  for (const Triangle& triangle : bodies.triangles()) {
    const Vec3& a = at(bodies.points_rest(), triangle[0]);
    const Vec3& b = at(bodies.points_rest(), triangle[1]);
    const Vec3& c = at(bodies.points_rest(), triangle[2]);
    const int cuts =
        static_cast<int>(std::clamp(std::ceil(longest_edge(a, b, c) / spacing), 1.0, double{most}));
    for (int i = 0; i <= cuts; ++i) {
      for (int j = 0; i + j <= cuts; ++j)
        samples.push_back(a + (double(i) / cuts) * (b - a) + (double(j) / cuts) * (c - a));
    }
  }
  return samples;
}

std::optional<Touch> touch_from_above(std::span<const Vec3> samples, double x, double y, double radius) {
  std::optional<Touch> first;
  for (const Vec3& sample : samples) {
    const double squared = (sample.x - x) * (sample.x - x) + (sample.y - y) * (sample.y - y);
    if (squared > radius * radius) continue;
    const double height = sample.z + std::sqrt(radius * radius - squared);
    if (!first || height > first->height) first = {height, std::sqrt(squared)};
  }
  return first;
}

Vec3 place_of_touch(const Bodies& bodies, double radius) {
  constexpr int lines = 31;  // lines of the lattice along each side
  constexpr double off_middle = 0.5;
  constexpr double on_slope = 0.3;
  const MeshStatistics box = mesh_statistics(bodies, bodies.points_rest());
  const Vec3 sides = box.upper - box.lower;
  const std::vector<Vec3> samples = surface_samples(bodies, radius / 3.0);
  Vec3 best{0.0, 0.0, box.upper.z + radius};
  double best_score = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < lines; ++i) {
    for (int j = 0; j < lines; ++j) {
      const double x = box.lower.x + (i + 0.5) / lines * sides.x;
      const double y = box.lower.y + (j + 0.5) / lines * sides.y;
      const auto touch = touch_from_above(samples, x, y, radius);
      if (!touch) continue;
      const double slope = touch->beside / radius;
      const double score =
          touch->height - off_middle * std::sqrt(x * x + y * y) - on_slope * sides.z * slope * slope;
      if (score <= best_score) continue;
      best_score = score;
      best = {x, y, touch->height};
    }
  }
  return best;
}

}  // namespace palpate

#include "io/picture_normals.hpp"

#include <cstddef>

#include "geometry/vector.hpp"

namespace palpate::io {
namespace {

constexpr double crease_cosine = 0.82;  // 35 degrees

/// The triangles at each point, as compressed rows.
struct PointTriangles {
  std::vector<std::size_t> begin;
  std::vector<std::size_t> values;

  PointTriangles(std::size_t points, std::span<const Triangle> triangles)
      : begin(points + 1), values(3 * triangles.size()) {
    for (const Triangle& t : triangles) {
      for (const Index corner : t) ++at(begin, corner + 1);
    }
    for (std::size_t i = 0; i < points; ++i) begin[i + 1] += begin[i];
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (const Index corner : triangles[i]) values[at(next, corner)++] = i;
    }
  }
};

}  // namespace

std::vector<std::array<Vec3, 3>> corner_normals(std::span<const Vec3> points,
                                                std::span<const Triangle> triangles) {
  std::vector<Vec3> areas;
  areas.reserve(triangles.size());
  for (const Triangle& t : triangles) {
    areas.push_back(cross(at(points, t[1]) - at(points, t[0]), at(points, t[2]) - at(points, t[0])));
  }
  const PointTriangles around(points.size(), triangles);
  std::vector<std::array<Vec3, 3>> normals(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Vec3 own = normalized(areas[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      Vec3 sum{};
      const Index point = triangles[i][c];
      for (std::size_t k = at(around.begin, point); k < at(around.begin, point + 1); ++k) {
        const Vec3& area = areas[around.values[k]];
        if (dot(own, normalized(area)) > crease_cosine) sum += area;
      }
      normals[i][c] = normalized(sum);
    }
  }
  return normals;
}

}  // namespace palpate::io

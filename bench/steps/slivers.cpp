#include "steps/slivers.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "geometry/vector.hpp"

namespace palpate::bench {
namespace {

/// Sines of 0.2, 0.5, 1, 2 and 5 degrees.
constexpr std::array<double, 5> sliver_sines{0.0034906, 0.0087265, 0.0174524, 0.0348995, 0.0871557};
constexpr double fraction_of_slivers = 0.25;
constexpr double fraction_of_path = 0.4;

/// Least flattest_sine() of the tets at a point, were it at `place`.
double flattest_at(const Bodies& bodies, const std::vector<Vec3>& points, Index point, const Vec3& place) {
  double least = std::numeric_limits<double>::infinity();
  for (const Index t : bodies.point_tets()[point]) {
    std::array<Vec3, 4> corners;
    const Tet& tet = at(bodies.tets(), t);
    for (std::size_t k = 0; k < 4; ++k) corners[k] = tet[k] == point ? place : at(points, tet[k]);
    least = std::min(least, flattest_sine(corners));
  }
  return least;
}

/// How far a point may go in a direction until a tet at it is as flat as `sine`: at most `reach`.
double distance_until(const Bodies& bodies, const std::vector<Vec3>& points, Index point,
                      const Vec3& direction, double reach, double sine) {
  const auto fits = [&](double distance) {
    return flattest_at(bodies, points, point, at(points, point) + distance * direction) >= sine;
  };
  if (!fits(0.0)) return 0.0;
  double low = 0.0;
  double high = reach;
  for (int i = 0; i < 30; ++i) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

double mean_edge_at(const Bodies& bodies, const std::vector<Vec3>& points, Index point) {
  double sum = 0.0;
  const auto edges = bodies.point_edges()[point];
  for (const Index e : edges) sum += length(at(points, bodies.other_end(e, point)) - at(points, point));
  return sum / static_cast<double>(edges.size());
}

/// Of any length but zero.
Vec3 hashed_direction(std::uint64_t seed, std::uint64_t index) {
  Vec3 d{2.0 * hashed_unit(seed, index, 0) - 1.0, 2.0 * hashed_unit(seed, index, 1) - 1.0,
         2.0 * hashed_unit(seed, index, 2) - 1.0};
  if (squared_length(d) < 1e-4) d = {1.0, 0.0, 0.0};
  return normalized(d);
}

}  // namespace

double hashed_unit(std::uint64_t seed, std::uint64_t index, std::uint64_t channel) {
  std::uint64_t z = (seed << 40U) + index * 8U + channel + 1U;
  z *= 0x9E3779B97F4A7C15U;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  z ^= z >> 31U;
  return static_cast<double>(z >> 11U) * 0x1p-53;
}

double flattest_sine(const std::array<Vec3, 4>& corners) {
  const auto& [a, b, c, d] = corners;
  const double volume = dot(b - a, cross(c - a, d - a));
  // Twice the area of the face opposite each corner.
  const std::array<double, 4> areas{length(cross(c - b, d - b)), length(cross(c - a, d - a)),
                                    length(cross(b - a, d - a)), length(cross(b - a, c - a))};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      // The edge i j belongs to the faces opposite the other two corners.
      std::array<std::size_t, 2> others{};
      for (std::size_t k = 0, n = 0; k < 4; ++k)
        if (k != i && k != j) others[n++] = k;
      const double product = areas[others[0]] * areas[others[1]];
      if (product <= 0.0) return 0.0;
      least = std::min(least, volume * length(corners[j] - corners[i]) / product);
    }
  }
  return least;
}

void make_slivers(TetMesh& mesh, std::uint64_t seed) {
  Bodies bodies;
  bodies.add("slivers", mesh);
  std::vector<std::uint8_t> outside(mesh.points.size(), 0);
  for (const Triangle& triangle : bodies.triangles())
    for (const Index p : triangle) at(outside, p) = 1;
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    const auto point = static_cast<Index>(i);
    if (outside[i] != 0 || bodies.point_tets()[point].empty()) continue;
    const bool sliver = hashed_unit(seed, i, 3) < fraction_of_slivers;
    const auto kind = static_cast<std::size_t>(hashed_unit(seed, i, 4) * sliver_sines.size());
    const double sine = sliver ? sliver_sines[kind] : sliver_sines.back();
    const Vec3 direction = hashed_direction(seed, i);
    const double reach = 2.0 * mean_edge_at(bodies, mesh.points, point);
    const double distance = distance_until(bodies, mesh.points, point, direction, reach, sine);
    mesh.points[i] += (sliver ? 1.0 : fraction_of_path) * distance * direction;
  }
}

}  // namespace palpate::bench

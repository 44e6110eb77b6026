#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <palpate/error.hpp>
#include <palpate/outcomes.hpp>

#include "geometry/box.hpp"
#include "geometry/disjoint_sets.hpp"
#include "geometry/triangle.hpp"

// The volume that a part of a surface encloses, by the divergence theorem.
namespace palpate {
namespace {

using Edge = std::array<Index, 2>;

void check(const Bodies& bodies, std::span<const Index> walls) {
  const auto count = static_cast<Index>(bodies.triangles().size());
  std::vector<Index> sorted(walls.begin(), walls.end());
  std::ranges::sort(sorted);
  if (sorted.empty()) throw Error("cavity", "walls", "no surface triangle", "one or more");
  if (sorted.front() < 0 || sorted.back() >= count)
    throw Error("cavity", "walls", "a triangle out of range", "surface triangles");
  if (std::ranges::adjacent_find(sorted) != sorted.end())
    throw Error("cavity", "walls", "a triangle for the second time", "each triangle once");
}

/// Edges of one triangle only, in the direction in which this triangle has them.
std::vector<Edge> border_of(const Bodies& bodies, std::span<const Index> walls) {
  std::map<Edge, int> count;  // of an edge in this direction, less those of the other
  for (const Index t : walls) {
    const Triangle& corners = at(bodies.triangles(), t);
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = corners[i];
      const Index b = corners[(i + 1) % 3];
      count[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  }
  std::vector<Edge> border;
  for (const auto& [edge, times] : count) {
    for (int i = 0; i < times; ++i) border.push_back(edge);
    for (int i = 0; i > times; --i) border.push_back({edge[1], edge[0]});
  }
  return border;
}

/// Groups border edges that are connected by points.
std::vector<std::vector<Edge>> openings_of(const Bodies& bodies, const std::vector<Edge>& border) {
  DisjointSets sets(bodies.points_rest().size());
  for (const Edge& edge : border) sets.join(edge[0], edge[1]);
  std::map<Index, std::vector<Edge>> openings;
  for (const Edge& edge : border) openings[sets.find(edge[0])].push_back(edge);
  std::vector<std::vector<Edge>> list;
  list.reserve(openings.size());
  for (auto& [set, edges] : openings) list.push_back(std::move(edges));
  return list;
}

/// The centroid of a line.
Vec3 centroid_of(const std::vector<Edge>& edges, std::span<const Vec3> positions) {
  Vec3 sum;
  double weight = 0.0;
  for (const Edge& edge : edges) {
    const Vec3& a = at(positions, edge[0]);
    const Vec3& b = at(positions, edge[1]);
    sum += (0.5 * length(b - a)) * (a + b);
    weight += length(b - a);
  }
  return weight > 0.0 ? (1.0 / weight) * sum : at(positions, edges.front()[0]);
}

}  // namespace

double volume_of(const Cavity& cavity, const Bodies& bodies, std::span<const Vec3> positions) {
  const Vec3 origin = at(positions, at(bodies.triangles(), cavity.walls.front())[0]);  // for small rounding
  const auto six_volumes = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    return dot(a - origin, cross(b - origin, c - origin));
  };
  double sum = 0.0;
  for (const Index t : cavity.walls) {
    const auto [a, b, c] = corners_of(positions, at(bodies.triangles(), t));
    sum += six_volumes(a, b, c);
  }
  for (const std::vector<Edge>& opening : cavity.openings) {
    const Vec3 center = centroid_of(opening, positions);
    for (const Edge& edge : opening)
      sum += six_volumes(at(positions, edge[1]), at(positions, edge[0]), center);
  }
  return cavity.sign * sum / 6.0;
}

Cavity cavity(const Bodies& bodies, std::span<const Index> walls) {
  check(bodies, walls);
  Cavity made{.walls = {walls.begin(), walls.end()},
              .openings = openings_of(bodies, border_of(bodies, walls))};
  Box box;
  for (const Index t : walls)
    for (const Vec3& corner : corners_of(bodies.points_rest(), at(bodies.triangles(), t))) box.extend(corner);
  const double size = length(box.upper - box.lower);
  const double volume = volume_of(made, bodies, bodies.points_rest());
  constexpr double rounding = 1e-9;
  if (std::abs(volume) <= rounding * size * size * size)
    throw Error("cavity", "walls", "a part of a surface that encloses no volume", "the walls of a cavity");
  made.sign = volume > 0.0 ? 1.0 : -1.0;
  return made;
}

}  // namespace palpate

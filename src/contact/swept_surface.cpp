#include "contact/swept_surface.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace palpate {
namespace {

Index edge_between(const Bodies& bodies, Index a, Index b) {
  for (const Index edge : bodies.point_edges()[a])
    if (bodies.other_end(edge, a) == b) return edge;
  return -1;
}

/// Appends what is not in another row yet, ascending.
class OwnedRows {
 public:
  OwnedRows(Rows& rows, std::size_t size) : rows_(rows), owned_(size, 0) {}
  void add(Index i) {
    if (at(owned_, i) != 0) return;
    at(owned_, i) = 1;
    rows_.values.push_back(i);
  }
  void end_row() {
    std::sort(rows_.values.begin() + rows_.begin.back(), rows_.values.end());
    rows_.begin.push_back(static_cast<Index>(rows_.values.size()));
  }

 private:
  Rows& rows_;
  std::vector<std::uint8_t> owned_;
};

}  // namespace

SweptSurface::SweptSurface(const Bodies& bodies)
    : clusters(make_triangle_clusters(bodies)),
      of_body(bodies.bodies().size()),
      of_thinnest(bodies.bodies().size(), std::numeric_limits<double>::infinity()),
      edge_triangles_(bodies.edges().size(), {-1, -1}) {
  OwnedRows owned_points(points, bodies.points_rest().size());
  OwnedRows owned_edges(edges, bodies.edges().size());
  for (const Cluster& cluster : clusters.clusters) {
    double least = std::numeric_limits<double>::infinity();
    for (const Index triangle : clusters.primitives_of(cluster)) {
      const Triangle& corners = at(bodies.triangles(), triangle);
      for (std::size_t c = 0; c < 3; ++c) {
        owned_points.add(corners[c]);
        const Index edge = edge_between(bodies, corners[c], corners[(c + 1) % 3]);
        owned_edges.add(edge);
        auto& sides = at(edge_triangles_, edge);
        if (sides[0] < 0) {
          sides[0] = triangle;
        } else if (sides[1] < 0) {
          sides[1] = triangle;
        }
      }
      least = std::min(least, height_behind(bodies, triangle));
    }
    owned_points.end_row();
    owned_edges.end_row();
    thickness.push_back(least);
    at(of_thinnest, cluster.body) = std::min(at(of_thinnest, cluster.body), least);
    const auto number = static_cast<Index>(thickness.size()) - 1;
    Range& range = at(of_body, cluster.body);
    if (range.size() == 0) range.begin = number;
    range.end = number + 1;
  }
}

Vec3 SweptSurface::outward(const Bodies& bodies, std::span<const Vec3> positions, Index triangle) {
  const Triangle& t = at(bodies.triangles(), triangle);
  const Vec3& a = at(positions, t[0]);
  return normalized(cross(at(positions, t[1]) - a, at(positions, t[2]) - a));
}

Vec3 SweptSurface::outward_of_edge(const Bodies& bodies, std::span<const Vec3> positions, Index edge) const {
  Vec3 sum;
  for (const Index triangle : at(edge_triangles_, edge))
    if (triangle >= 0) sum += outward(bodies, positions, triangle);
  return sum;
}

Index tet_behind(const Bodies& bodies, Index triangle) {
  const Triangle& corners = at(bodies.triangles(), triangle);
  for (const Index tet : bodies.point_tets()[corners[0]]) {
    const Tet& t = at(bodies.tets(), tet);
    const auto has = [&](Index corner) { return std::find(t.begin(), t.end(), corner) != t.end(); };
    if (!has(corners[1]) || !has(corners[2])) continue;
    // Two tets share the corners of an inner face only.
    return tet;
  }
  return -1;
}

double height_behind(const Bodies& bodies, Index triangle) {
  const Tet& tet = at(bodies.tets(), tet_behind(bodies, triangle));
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = at(bodies.points_rest(), tet[i]);
  const double volume = dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
  const Triangle& t = at(bodies.triangles(), triangle);
  const Vec3& a = at(bodies.points_rest(), t[0]);
  const double area = length(cross(at(bodies.points_rest(), t[1]) - a, at(bodies.points_rest(), t[2]) - a));
  return area > 0.0 ? volume / area : 0.0;
}

}  // namespace palpate

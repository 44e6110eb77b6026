#include "contact/surface_clusters.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

/// Appends items that are not in another row yet, ascending.
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

SurfaceClusters::SurfaceClusters(const Bodies& bodies)
    : clusters(make_triangle_clusters(bodies)),
      of_body(bodies.bodies().size()),
      of_thinnest(bodies.bodies().size(), std::numeric_limits<double>::infinity()) {
  OwnedRows owned_points(points, bodies.points_rest().size());
  OwnedRows owned_edges(edges, bodies.edges().size());
  for (const Cluster& cluster : clusters.clusters) {
    double least = std::numeric_limits<double>::infinity();
    for (const Index triangle : clusters.primitives_of(cluster)) {
      for (const Index corner : at(bodies.triangles(), triangle)) owned_points.add(corner);
      for (const Index edge : at(bodies.triangle_edges(), triangle)) owned_edges.add(edge);
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

double height_behind(const Bodies& bodies, Index triangle) {
  const Tet& tet = at(bodies.tets(), at(bodies.triangle_tets(), triangle));
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = at(bodies.points_rest(), tet[i]);
  const double volume = dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]);
  const double area = length(area_vector(bodies.points_rest(), at(bodies.triangles(), triangle)));
  return area > 0.0 ? volume / area : 0.0;
}

}  // namespace palpate

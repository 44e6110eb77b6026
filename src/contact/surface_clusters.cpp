#include "contact/surface_clusters.hpp"

#include <algorithm>
#include <cstdint>

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
    : clusters(make_triangle_clusters(bodies)), of_body(bodies.bodies().size()) {
  OwnedRows owned_points(points, bodies.points_rest().size());
  OwnedRows owned_edges(edges, bodies.edges().size());
  Index number = 0;
  for (const Cluster& cluster : clusters.clusters) {
    for (const Index triangle : clusters.primitives_of(cluster)) {
      for (const Index corner : at(bodies.triangles(), triangle)) owned_points.add(corner);
      for (const Index edge : at(bodies.triangle_edges(), triangle)) owned_edges.add(edge);
    }
    owned_points.end_row();
    owned_edges.end_row();
    Range& range = at(of_body, cluster.body);
    if (range.size() == 0) range.begin = number;
    range.end = ++number;
  }
}

}  // namespace palpate

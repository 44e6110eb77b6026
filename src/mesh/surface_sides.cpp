#include "mesh/surface_sides.hpp"

#include <algorithm>

#include "geometry/vector.hpp"

namespace palpate {
namespace {

Index edge_between(const Bodies& bodies, Index p, Index q) {
  const std::span<const Index> edges = bodies.point_edges()[p];
  return *std::ranges::find_if(edges, [&](Index edge) { return bodies.other_end(edge, p) == q; });
}

}  // namespace

TriangleOfFace::TriangleOfFace(const Bodies& bodies) {
  first_.reserve(bodies.tets().size());
  Index triangle = 0;
  for (const std::array<Index, 4>& neighbors : bodies.tet_neighbors()) {
    first_.push_back(triangle);
    triangle += static_cast<Index>(std::ranges::count(neighbors, -1));
  }
}

SurfaceSides surface_sides(const Bodies& bodies) {
  const std::span<const Triangle> triangles = bodies.triangles();
  SurfaceSides sides{std::vector<std::array<Index, 3>>(triangles.size()),
                     std::vector<std::array<Index, 3>>(triangles.size(), {-1, -1, -1}),
                     std::vector<std::array<Index, 2>>(bodies.edges().size(), {-1, -1})};
  std::vector<int> met(bodies.edges().size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index edge = edge_between(bodies, triangles[t][(i + 1) % 3], triangles[t][(i + 2) % 3]);
      sides.edges[t][i] = edge;
      int& count = at(met, edge);
      if (count < 2) at(at(sides.triangles, edge), count) = static_cast<Index>(t);
      ++count;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index edge = sides.edges[t][i];
      const auto& [a, b] = at(sides.triangles, edge);
      if (at(met, edge) == 2) sides.neighbors[t][i] = a == static_cast<Index>(t) ? b : a;
    }
  }
  return sides;
}

}  // namespace palpate

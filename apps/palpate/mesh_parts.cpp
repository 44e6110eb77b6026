#include "mesh_parts.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <utility>

#include "fem/lumping.hpp"
#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

std::vector<double> piece_volumes(const Bodies& bodies, const Range& tets) {
  std::vector<bool> seen(static_cast<std::size_t>(tets.size()), false);
  std::vector<double> volumes;
  std::vector<Index> open;
  const auto reach = [&](Index tet) {
    if (tet < 0 || seen[static_cast<std::size_t>(tet - tets.begin)]) return;
    seen[static_cast<std::size_t>(tet - tets.begin)] = true;
    open.push_back(tet);
  };
  for (Index first = tets.begin; first < tets.end; ++first) {
    reach(first);
    if (open.empty()) continue;
    volumes.push_back(0.0);
    while (!open.empty()) {
      const Index tet = open.back();
      open.pop_back();
      volumes.back() += fem::tet_volume_rest(bodies, tet);
      for (const Index next : at(bodies.tet_neighbors(), tet)) reach(next);
    }
  }
  std::ranges::sort(volumes, std::greater());
  return volumes;
}

Index shared_edges(const Bodies& bodies, const Range& triangles) {
  std::vector<Edge> edges;
  for (Index t = triangles.begin; t < triangles.end; ++t) {
    const Triangle& c = at(bodies.triangles(), t);
    for (std::size_t i = 0; i < 3; ++i) {
      const Index next = c[(i + 1) % 3];
      edges.push_back({std::min(c[i], next), std::max(c[i], next)});
    }
  }
  std::ranges::sort(edges);
  Index shared = 0;
  for (auto edge = edges.begin(); edge != edges.end();) {
    const auto end = std::upper_bound(edge, edges.end(), *edge);
    if (end - edge > 2) ++shared;
    edge = end;
  }
  return shared;
}

/// Number of rings of edges around a point: one where the surface is a manifold.
std::size_t rings(const std::vector<Edge>& across) {
  std::map<Index, Index> lower;  // for each point of the rings: a lower point of the same ring, or itself
  const auto lowest = [&](Index p) {
    for (lower.try_emplace(p, p); lower.at(p) != p;) p = lower.at(p) = lower.at(lower.at(p));
    return p;
  };
  for (const Edge& edge : across) {
    const std::pair<Index, Index> ends = std::minmax({lowest(edge[0]), lowest(edge[1])});
    lower.at(ends.second) = ends.first;
  }
  return static_cast<std::size_t>(
      std::ranges::count_if(lower, [](const auto& entry) { return entry.first == entry.second; }));
}

Index touching_points(const Bodies& bodies, const Body& body) {
  std::vector<std::vector<Edge>> across(static_cast<std::size_t>(body.points.size()));
  for (Index t = body.triangles.begin; t < body.triangles.end; ++t) {
    const Triangle& c = at(bodies.triangles(), t);
    for (std::size_t i = 0; i < 3; ++i)
      at(across, c[i] - body.points.begin).push_back({c[(i + 1) % 3], c[(i + 2) % 3]});
  }
  return static_cast<Index>(
      std::ranges::count_if(across, [](const std::vector<Edge>& edges) { return rings(edges) > 1; }));
}

}  // namespace

MeshParts mesh_parts(const Bodies& bodies, Index body) {
  const Body& b = at(bodies.bodies(), body);
  return {piece_volumes(bodies, b.tets), shared_edges(bodies, b.triangles), touching_points(bodies, b)};
}

}  // namespace palpate::app

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

#include "geometry/predicates.hpp"
#include "geometry/vector.hpp"
#include "mesh/faces.hpp"
#include "mesh/grouped.hpp"

namespace palpate {
namespace {

constexpr std::array<std::array<std::size_t, 2>, 6> edge_corners{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

/// The topology of one mesh, with indices local to it.
struct Topology {
  std::vector<Edge> edges;
  std::vector<Triangle> triangles;
  std::vector<std::array<Index, 4>> tet_neighbors;
  std::vector<Index> first_triangles;
  std::vector<Index> triangle_tets;
  std::vector<std::array<Index, 3>> triangle_edges;
  std::vector<std::array<Index, 3>> triangle_neighbors;
  std::vector<std::array<Index, 2>> edge_triangles;
  Rows point_edges;
  Rows point_tets;
};

std::vector<Edge> unique_edges(const std::vector<Tet>& tets) {
  std::vector<Edge> edges;
  edges.reserve(tets.size() * 6);
  for (const Tet& tet : tets) {
    for (const auto& [i, j] : edge_corners)
      edges.push_back({std::min(tet[i], tet[j]), std::max(tet[i], tet[j])});
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  edges.shrink_to_fit();
  return edges;
}

/// For each point, the indices of the primitives with that corner, ascending.
template <class Corners>
Rows rows_of_points(std::size_t n_points, const std::vector<Corners>& primitives) {
  return grouped(primitives.size(), n_points, [&](std::size_t p) { return primitives[p]; });
}

/// Finds common faces of tets. Fills tet_neighbors, and triangles with the faces of one tet only.
void pair_faces(const std::vector<Tet>& tets, const std::string& source, Topology& topology) {
  struct Face {
    Triangle sorted;
    Index tet;
    Index opposite;
    bool even;  ///< whether sorting the corners (counter-clockwise from outside) took an even number of swaps
    bool operator<(const Face& o) const {
      return std::tie(sorted, tet, opposite) < std::tie(o.sorted, o.tet, o.opposite);
    }
  };
  std::vector<Face> faces;
  faces.reserve(tets.size() * 4);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      const auto& [i, j, k] = outward_face[opposite];
      const Triangle corners{tets[t][i], tets[t][j], tets[t][k]};
      Triangle sorted = corners;
      std::sort(sorted.begin(), sorted.end());
      const int swaps = (corners[0] > corners[1] ? 1 : 0) + (corners[0] > corners[2] ? 1 : 0) +
                        (corners[1] > corners[2] ? 1 : 0);
      const bool even = swaps % 2 == 0;
      faces.push_back({sorted, static_cast<Index>(t), static_cast<Index>(opposite), even});
    }
  }
  std::sort(faces.begin(), faces.end());
  topology.tet_neighbors.assign(tets.size(), {-1, -1, -1, -1});
  const auto neighbor = [&](const Face& f) -> Index& {
    return at(at(topology.tet_neighbors, f.tet), f.opposite);
  };
  for (std::size_t f = 0; f < faces.size();) {
    std::size_t next = f + 1;
    while (next < faces.size() && faces[next].sorted == faces[f].sorted) ++next;
    if (next - f > 2) {
      throw Error(source, "tet " + std::to_string(faces[f + 2].tet),
                  "a face that tets " + std::to_string(faces[f].tet) + " and " +
                      std::to_string(faces[f + 1].tet) + " have already",
                  "at most two tets on a face");
    }
    if (next - f == 2) {
      if (faces[f].even == faces[f + 1].even) {
        throw Error(source, "tet " + std::to_string(faces[f + 1].tet),
                    "the same side of a face as tet " + std::to_string(faces[f].tet) + ": they overlap",
                    "tets on both sides of a face");
      }
      neighbor(faces[f]) = faces[f + 1].tet;
      neighbor(faces[f + 1]) = faces[f].tet;
    }
    f = next;
  }
  for (std::size_t t = 0; t < tets.size(); ++t) {
    topology.first_triangles.push_back(static_cast<Index>(topology.triangles.size()));
    for (std::size_t opposite = 0; opposite < 4; ++opposite) {
      if (topology.tet_neighbors[t][opposite] >= 0) continue;
      const auto& [i, j, k] = outward_face[opposite];
      topology.triangles.push_back({tets[t][i], tets[t][j], tets[t][k]});
      topology.triangle_tets.push_back(static_cast<Index>(t));
    }
  }
}

/// Neighbours of the triangles across their edges.
void join_triangles(Topology& topology) {
  const std::vector<Triangle>& triangles = topology.triangles;
  topology.triangle_edges.resize(triangles.size());
  topology.triangle_neighbors.assign(triangles.size(), {-1, -1, -1});
  topology.edge_triangles.assign(topology.edges.size(), {-1, -1});
  std::vector<int> met(topology.edges.size(), 0);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(triangles[t][(i + 1) % 3], triangles[t][(i + 2) % 3]);
      const auto place = std::ranges::lower_bound(topology.edges, Edge{low, high});
      const auto edge = static_cast<Index>(place - topology.edges.begin());
      topology.triangle_edges[t][i] = edge;
      int& count = at(met, edge);
      if (count < 2) at(at(topology.edge_triangles, edge), count) = static_cast<Index>(t);
      ++count;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Index edge = topology.triangle_edges[t][i];
      const auto& [a, b] = at(topology.edge_triangles, edge);
      if (at(met, edge) == 2) topology.triangle_neighbors[t][i] = a == static_cast<Index>(t) ? b : a;
    }
  }
}

Topology build_topology(const TetMesh& mesh, const std::string& source) {
  Topology topology;
  topology.edges = unique_edges(mesh.tets);
  pair_faces(mesh.tets, source, topology);
  join_triangles(topology);
  topology.point_edges = rows_of_points(mesh.points.size(), topology.edges);
  topology.point_tets = rows_of_points(mesh.points.size(), mesh.tets);
  return topology;
}

Index count_of(const auto& container) {
  return static_cast<Index>(container.size());
}

Range append_range(const auto& all, const auto& part) {
  return {count_of(all), count_of(all) + count_of(part)};
}

void append_shifted(std::vector<Index>& all, const std::vector<Index>& part, Index shift) {
  for (const Index value : part) all.push_back(value + shift);
}

/// Appends rows of indices, shifted to their indices among all bodies; -1 stays.
template <std::size_t n>
void append_shifted(std::vector<std::array<Index, n>>& all, const std::vector<std::array<Index, n>>& part,
                    Index shift) {
  for (std::array<Index, n> corners : part) {
    for (Index& corner : corners) corner += corner < 0 ? 0 : shift;
    all.push_back(corners);
  }
}

void append_shifted(Rows& all, const Rows& part, Index shift) {
  const Index first = all.begin.back();
  for (std::size_t i = 1; i < part.begin.size(); ++i) all.begin.push_back(first + part.begin[i]);
  for (const Index value : part.values) all.values.push_back(value + shift);
}

/// Reserves room for `part` behind `all`. At least doubles the capacity, so that adding many bodies takes
/// linear time.
void grow(auto& all, const auto& part) {
  const std::size_t needed = all.size() + part.size();
  if (needed > all.capacity()) all.reserve(std::max(needed, 2 * all.capacity()));
}

void grow_rows(Rows& all, const Rows& part) {
  grow(all.begin, part.begin);
  grow(all.values, part.values);
}

void check_room(std::size_t have, std::size_t more, const char* what, const std::string& source) {
  if (have + more > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw Error(source, "", std::to_string(have + more) + " " + what + " in all bodies",
                "at most 2147483647");
  }
}

}  // namespace

Index Bodies::add(std::string name, TetMesh mesh) {
  check_room(tets_.size() * 4, mesh.tets.size() * 4, "tet corners", name);
  check_room(points_rest_.size(), mesh.points.size(), "points", name);
  const MeshNotes notes = check_mesh(mesh, name);
  const Topology topology = build_topology(mesh, name);

  // Allocates all memory first. Nothing below throws, so a refused body changes nothing.
  grow(bodies_, std::array<int, 1>{});
  grow(notes_, std::array<int, 1>{});
  grow(points_rest_, mesh.points);
  grow(body_of_point_, mesh.points);
  grow(tets_, mesh.tets);
  grow(tet_neighbors_, mesh.tets);
  grow(edges_, topology.edges);
  grow(edge_triangles_, topology.edges);
  grow(triangles_, topology.triangles);
  grow(first_triangles_, mesh.tets);
  grow(triangle_tets_, topology.triangles);
  grow(triangle_edges_, topology.triangles);
  grow(triangle_neighbors_, topology.triangles);
  grow_rows(point_edges_, topology.point_edges);
  grow_rows(point_tets_, topology.point_tets);

  Body body{std::move(name), append_range(points_rest_, mesh.points), append_range(edges_, topology.edges),
            append_range(triangles_, topology.triangles), append_range(tets_, mesh.tets)};
  const Index id = body_count();
  points_rest_.insert(points_rest_.end(), mesh.points.begin(), mesh.points.end());
  body_of_point_.insert(body_of_point_.end(), mesh.points.size(), id);
  append_shifted(tets_, mesh.tets, body.points.begin);
  append_shifted(edges_, topology.edges, body.points.begin);
  append_shifted(triangles_, topology.triangles, body.points.begin);
  append_shifted(tet_neighbors_, topology.tet_neighbors, body.tets.begin);
  append_shifted(first_triangles_, topology.first_triangles, body.triangles.begin);
  append_shifted(triangle_tets_, topology.triangle_tets, body.tets.begin);
  append_shifted(triangle_edges_, topology.triangle_edges, body.edges.begin);
  append_shifted(triangle_neighbors_, topology.triangle_neighbors, body.triangles.begin);
  append_shifted(edge_triangles_, topology.edge_triangles, body.triangles.begin);
  append_shifted(point_edges_, topology.point_edges, body.edges.begin);
  append_shifted(point_tets_, topology.point_tets, body.tets.begin);
  bodies_.push_back(std::move(body));
  notes_.push_back(notes);
  return id;
}

void Bodies::set_points_rest(std::span<const Vec3> points) {
  if (points.size() != points_rest_.size()) {
    throw Error("bodies", "points_rest", std::to_string(points.size()) + " points",
                std::to_string(points_rest_.size()));
  }
  for (const Body& body : bodies_) {
    for (Index t = body.tets.begin; t < body.tets.end; ++t) {
      const Tet& c = at(tets_, t);
      if (orient3d(at(points, c[0]), at(points, c[1]), at(points, c[2]), at(points, c[3])) > 0) continue;
      std::string where = "tet ";
      where.append(std::to_string(t - body.tets.begin));
      throw Error(body.name, where, "no positive volume", "a tet that is not flat or inverted");
    }
  }
  points_rest_.assign(points.begin(), points.end());
}

}  // namespace palpate

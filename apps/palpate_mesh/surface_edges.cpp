#include "surface_edges.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "geometry/box.hpp"
#include "geometry/disjoint_sets.hpp"
#include "geometry/vector.hpp"

namespace palpate::app {
namespace {

/// An edge with an odd number of triangles.
struct OddEdge {
  Edge along;  ///< in the direction of its first triangle
  std::size_t first_triangle;
  std::size_t triangles;
};

struct EdgeUse {
  Edge sorted;
  bool ascends;
  std::size_t triangle;
};

std::vector<EdgeUse> uses_of(const Surface& surface) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Triangle& c = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const Index a = c[i];
      const Index b = c[(i + 1) % 3];
      uses.push_back({{std::min(a, b), std::max(a, b)}, a < b, t});
    }
  }
  std::ranges::sort(uses, {}, [](const EdgeUse& u) { return std::tuple(u.sorted, u.triangle, u.ascends); });
  return uses;
}

/// Edges with an odd number of triangles, in the order of their first triangle. Counts the other edges in
/// `edges`.
std::vector<OddEdge> odd_edges(const std::vector<EdgeUse>& uses, SurfaceEdges& edges) {
  std::vector<OddEdge> odd;
  for (std::size_t begin = 0; begin < uses.size();) {
    std::size_t end = begin;
    std::size_t ascending = 0;
    for (; end < uses.size() && uses[end].sorted == uses[begin].sorted; ++end)
      ascending += uses[end].ascends ? 1U : 0U;
    const std::size_t count = end - begin;
    const Edge& e = uses[begin].sorted;
    if (count % 2 == 1) {
      odd.push_back({uses[begin].ascends ? e : Edge{e[1], e[0]}, uses[begin].triangle, count});
    } else {
      if (count > 2) edges.shared_edges.push_back(e);
      if (2 * ascending != count) edges.one_sided = false;
    }
    begin = end;
  }
  std::ranges::sort(odd, {}, [](const OddEdge& o) { return std::tuple(o.first_triangle, o.along); });
  return odd;
}

/// Finds the rings among the odd edges: at each point an even number of them meets, because each triangle has
/// two edges at each of its points.
class RingFinder {
 public:
  explicit RingFinder(const std::vector<OddEdge>& edges) : edges_(edges), used_(edges.size(), false) {
    for (std::size_t e = 0; e < edges.size(); ++e) {
      for (const Index end : edges[e].along) at_point_.emplace_back(end, e);
    }
    std::ranges::sort(at_point_);
  }

  /// The next ring: indices of its edges; empty after the last ring.
  std::vector<std::size_t> next() {
    while (first_ < edges_.size() && used_[first_]) ++first_;
    if (first_ == edges_.size()) return {};
    // The walk can end only where it began. Each loop that it closes before is a ring of its own.
    std::vector<std::size_t> walk;
    Index point = edges_[first_].along[0];
    std::unordered_map<Index, std::ptrdiff_t> passed{{point, 0}};  // number of edges walked until each point
    while (true) {
      const std::size_t edge = unused_at(point);
      used_[edge] = true;
      walk.push_back(edge);
      const Edge& along = edges_[edge].along;
      point = along[0] == point ? along[1] : along[0];
      const auto [before, is_new] = passed.try_emplace(point, std::ssize(walk));
      if (is_new) continue;
      const auto begin = walk.begin() + before->second;
      for (auto e = walk.begin(); e != begin; ++e) used_[*e] = false;  // these edges belong to a later ring
      return {begin, walk.end()};
    }
  }

 private:
  [[nodiscard]] std::size_t unused_at(Index point) const {
    auto place = std::ranges::lower_bound(at_point_, std::pair(point, std::size_t{0}));
    while (used_[place->second]) ++place;
    return place->second;
  }

  const std::vector<OddEdge>& edges_;
  std::vector<bool> used_;
  std::vector<std::pair<Index, std::size_t>> at_point_;
  std::size_t first_ = 0;
};

/// Sets of points that are connected along the edges.
DisjointSets edge_groups(const std::vector<OddEdge>& edges, std::size_t points) {
  DisjointSets groups(points);
  for (const OddEdge& edge : edges) groups.join(edge.along[0], edge.along[1]);
  return groups;
}

Hole hole_of(const std::vector<std::size_t>& ring, const std::vector<OddEdge>& edges,
             const Surface& surface) {
  Hole hole;
  Box box;
  for (const std::size_t e : ring) {
    hole.edges.push_back(edges[e].along);
    for (const Index end : edges[e].along) box.extend(at(surface.points, end));
  }
  hole.size = length(box.upper - box.lower);
  return hole;
}

}  // namespace

SurfaceEdges edges_of(const Surface& surface) {
  SurfaceEdges result;
  std::vector<OddEdge> odd = odd_edges(uses_of(surface), result);
  if (odd.empty()) return result;
  result.first_bad = odd.front().along;
  result.triangles_at_first = odd.front().triangles;
  DisjointSets groups = edge_groups(odd, surface.points.size());
  std::vector<bool> hangs(
      surface.points.size(),
      false);  // whether a group of edges touches an edge of three triangles; by its lowest point
  for (const OddEdge& edge : odd) {
    if (edge.triangles > 1) hangs[static_cast<std::size_t>(groups.find(edge.along[0]))] = true;
  }
  std::vector<OddEdge> borders;
  for (const OddEdge& edge : odd) {
    if (hangs[static_cast<std::size_t>(groups.find(edge.along[0]))]) {
      ++result.odd_edges;
    } else {
      borders.push_back(edge);
    }
  }
  RingFinder finder(borders);
  for (auto ring = finder.next(); !ring.empty(); ring = finder.next())
    result.holes.push_back(hole_of(ring, borders, surface));
  return result;
}

std::vector<Index> touching_points(const Surface& surface) {
  struct Corner {
    Index point;
    Edge across;
  };
  std::vector<Corner> corners;
  corners.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    for (std::size_t i = 0; i < 3; ++i) corners.push_back({t[i], {t[(i + 1) % 3], t[(i + 2) % 3]}});
  }
  std::ranges::sort(corners, {}, [](const Corner& c) { return std::tuple(c.point, c.across); });
  std::vector<Index> touching;
  for (std::size_t begin = 0; begin < corners.size();) {
    std::map<Index, Index>
        lower;  // for each neighbour of this point: a lower neighbour that is connected to it, or itself
    const auto lowest = [&](Index p) {
      for (lower.try_emplace(p, p); lower.at(p) != p;) p = lower.at(p) = lower.at(lower.at(p));
      return p;
    };
    std::size_t end = begin;
    for (; end < corners.size() && corners[end].point == corners[begin].point; ++end) {
      const auto [low, high] = std::minmax({lowest(corners[end].across[0]), lowest(corners[end].across[1])});
      lower.at(high) = low;
    }
    const auto parts = std::ranges::count_if(lower, [](const auto& p) { return p.first == p.second; });
    if (parts > 1) touching.push_back(corners[begin].point);
    begin = end;
  }
  return touching;
}

void close_hole(Surface& surface, const Hole& hole) {
  Vec3 sum;
  for (const Edge& edge : hole.edges) sum = sum + at(surface.points, edge[0]) + at(surface.points, edge[1]);
  const auto middle = static_cast<Index>(surface.points.size());
  surface.points.push_back((0.5 / static_cast<double>(hole.edges.size())) * sum);
  for (const Edge& edge : hole.edges) surface.triangles.push_back({edge[1], edge[0], middle});
}

}  // namespace palpate::app

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/all_triangles.hpp"
#include "contact/surface_normals.hpp"
#include "geometry/vector.hpp"

namespace palpate::test {

/// The formulas of docs/depth.md (Planes, Depth, Deep contacts) as they stand there, from all triangles of a
/// body and a dense system of equations. Only interpolated normals are those of the library.
class DepthFormulas {
 public:
  struct Result {
    double depth = 0.0;
    Vec3 direction;
    double certainty = 0.0;
    double agreement = 0.0;  ///< length of the mean normal
    double plane_certainty = 0.0;
    double distance = 0.0;    ///< mean of the distances to the planes
    bool is_raised = false;   ///< to the distance of the surface
    double relative = 0.0;    ///< depth as in the section "Depth", in mean edge lengths at the point
    double deepest = 0.0;     ///< D, the largest of these in the region
    bool is_bent = false;     ///< deep, and the straight exit ends inside. This needs a convex body
    bool is_defined = false;  ///< the region has a plane
  };
  /// What the planes were made of.
  struct Used {
    int crossings = 0;
    int edges_with_several = 0;
    int near_triangles = 0;
    int links = 0;

    Used& operator+=(const Used& other) {
      crossings += other.crossings;
      edges_with_several += other.edges_with_several;
      near_triangles += other.near_triangles;
      links += other.links;
      return *this;
    }
  };

  DepthFormulas(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts)
      : bodies_(bodies), x_(positions), contacts_(contacts), normals_(bodies) {
    for (Index body = 0; body < bodies.body_count(); ++body) surfaces_.emplace_back(bodies, positions, body);
    for (Index c = 0; c < static_cast<Index>(contacts.size()); ++c) own_.push_back(own_planes(c));
    results_.resize(own_.size());
    std::vector<int> reached(own_.size(), 0);
    for (Index c = 0; c < static_cast<Index>(own_.size()); ++c) {
      if (at(reached, c) != 0) continue;
      std::vector<Index> region{c};
      at(reached, c) = 1;
      for (std::size_t next = 0; next < region.size(); ++next) {
        for (const auto& [other, weight] : at(own_, region[next]).links)
          if (std::exchange(at(reached, other), 1) == 0) region.push_back(other);
      }
      solve_region(region);
    }
  }
  [[nodiscard]] const Result& result(std::size_t contact) const { return results_[contact]; }
  [[nodiscard]] const Used& used() const { return used_; }

 private:
  using Number = long double;
  using Row = std::array<Number, 5>;  ///< the number 1, offset, normal

  /// The planes of a contact's own crossings and near triangles.
  struct Own {
    Row sum{};           ///< of w_ik B_ik; first W_i
    double edges = 0.0;  ///< sum of 1 / l^2 over all edges
    int edge_count = 0;
    std::vector<std::pair<Index, double>> links;  ///< contact j, m_ij
  };

  /// The contact of a point with a body, or -1.
  [[nodiscard]] Index contact_of(Index point, Index body) const {
    for (std::size_t c = 0; c < contacts_.size(); ++c)
      if (contacts_.point[c] == point && contacts_.body[c] == body) return static_cast<Index>(c);
    return -1;
  }
  static void add(Row& sum, double w, const Vec3& x, const Vec3& n) {
    const Number offset =
        static_cast<Number>(x.x) * n.x + static_cast<Number>(x.y) * n.y + static_cast<Number>(x.z) * n.z;
    const Row plane{1.0L, offset, n.x, n.y, n.z};
    for (std::size_t k = 0; k < plane.size(); ++k) sum[k] += w * plane[k];
  }

  /// Adds the planes of a border edge's crossings; returns the sum of their weights.
  double add_border_edge(Own& own, const Vec3& p, const Vec3& q, Index body) {
    const Vec3 edge = q - p;
    const double l = length(edge);
    const std::vector<SegmentCrossing> exits = at(surfaces_, body).crossings(p, q);
    if (exits.empty()) return 0.0;
    std::vector<Vec3> normals;
    std::vector<double> fractions;
    double sum = 0.0;
    for (const auto& [t, triangle, leaves] : exits) {
      normals.push_back(
          normals_.at_point_now(x_, triangle, p + t * edge, std::max(0.0, std::min(t, 1.0 - t)) * l));
      const double size = std::max(0.0, dot(normals.back(), edge) / l) / (1.0 - t);
      fractions.push_back(leaves ? size : -size);
      sum += fractions.back();
    }
    if (exits.size() == 1 || sum <= 0.02) {
      // The edge only grazes the surface: the last crossing counts.
      const auto last = std::ranges::max_element(exits, {}, &SegmentCrossing::t) - exits.begin();
      fractions.assign(exits.size(), 0.0);
      at(fractions, last) = sum = 1.0;
    }
    double weights = 0.0;
    for (std::size_t i = 0; i < exits.size(); ++i) {
      const double t = exits[i].t;
      const double w = fractions[i] / sum * (1.0 / (t * t) - 0.9) / (l * l);
      add(own.sum, w, p + t * edge, normals[i]);
      weights += w;
    }
    used_.crossings += static_cast<int>(exits.size());
    used_.edges_with_several += exits.size() > 1 ? 1 : 0;
    return weights;
  }

  /// Adds the planes of the surface that a walk through the tets of the body finds within the reach.
  void add_near_triangles(Own& own, const Vec3& p, Index first, double reach) {
    std::set<Index> visited{first};
    std::vector<Index> tets{first};
    for (std::size_t next = 0; next < tets.size(); ++next) {
      const Tet& tet = at(bodies_.tets(), tets[next]);
      for (std::size_t k = 0; k < 4; ++k) {
        const std::array<Vec3, 3> face{at(x_, tet[(k + 1) % 4]), at(x_, tet[(k + 2) % 4]),
                                       at(x_, tet[(k + 3) % 4])};
        const Vec3 x = nearest_of_triangle(face, p);
        const double distance = length(x - p);
        if (!(distance < reach)) continue;
        const Index neighbor = at(bodies_.tet_neighbors(), tets[next])[k];
        if (neighbor >= 0) {
          if (visited.insert(neighbor).second) tets.push_back(neighbor);
          continue;
        }
        const double excess = 1.0 / distance - 1.0 / reach;
        const Index triangle = bodies_.triangle_of_face(tets[next], k);
        add(own.sum, excess * excess, x, normals_.at_point_now(x_, triangle, x, distance));
        ++used_.near_triangles;
      }
    }
  }

  Own own_planes(Index c) {
    const Index point = at(contacts_.point, c);
    const Index body = at(contacts_.body, c);
    const Vec3& p = at(x_, point);
    Own own;
    double others = 0.0;  // as docs/depth.md defines the reach: 1 / root
    for (const Index e : bodies_.point_edges()[point]) {
      const Index end = bodies_.other_end(e, point);
      const double inverse = 1.0 / squared_length(at(x_, end) - p);
      own.edges += inverse;
      ++own.edge_count;
      if (const Index other = contact_of(end, body); other >= 0) {
        own.links.emplace_back(other, 0.1 * inverse);
        others += inverse;
      } else {
        others += add_border_edge(own, p, at(x_, end), body) + 0.9 * inverse;
      }
    }
    used_.links += static_cast<int>(own.links.size());
    add_near_triangles(own, p, at(contacts_.tet, c), 1.0 / std::sqrt(others));
    return own;
  }

  /// Gaussian elimination of a diagonally dominant system.
  static void solve(std::vector<std::vector<Number>>& a, std::vector<Row>& b) {
    const std::size_t n = a.size();
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        if (a[j][i] == 0.0L) continue;
        const Number factor = a[j][i] / a[i][i];
        for (std::size_t k = i; k < n; ++k) a[j][k] -= factor * a[i][k];
        for (std::size_t k = 0; k < b[j].size(); ++k) b[j][k] -= factor * b[i][k];
      }
    }
    for (std::size_t i = n; i-- > 0;) {
      for (std::size_t k = 0; k < b[i].size(); ++k) {
        for (std::size_t j = i + 1; j < n; ++j) b[i][k] -= a[i][j] * b[j][k];
        b[i][k] /= a[i][i];
      }
    }
  }

  void solve_region(const std::vector<Index>& region) {
    std::vector<std::size_t> place(own_.size(), 0);
    for (std::size_t i = 0; i < region.size(); ++i) at(place, region[i]) = i;
    std::vector<std::vector<Number>> a(region.size(), std::vector<Number>(region.size(), 0.0L));
    std::vector<Row> b;
    Number planes = 0.0L;
    for (std::size_t i = 0; i < region.size(); ++i) {
      const Own& own = at(own_, region[i]);
      planes += own.sum[0];
      a[i][i] = own.sum[0] + 0.01 * 0.1 * own.edges;
      for (const auto& [other, weight] : own.links) {
        a[i][i] += weight;
        a[i][at(place, other)] -= weight;
      }
      b.push_back(own.sum);
    }
    solve(a, b);
    double deepest = 0.0;
    for (std::size_t i = 0; i < region.size(); ++i) {
      Result& result = at(results_, region[i]);
      result = finished(region[i], b[i]);
      result.is_defined = planes > 0.0L;
      deepest = std::max(deepest, result.relative);
    }
    for (const Index c : region) {
      at(results_, c).deepest = deepest;
      if (deepest > 0.2) make_deep(c, std::min(1.0, (deepest - 0.2) / 0.2), at(results_, c));
    }
  }

  /// \param plane  solution of the system
  [[nodiscard]] Result finished(Index c, const Row& plane) const {
    const Vec3& p = at(x_, at(contacts_.point, c));
    const Number certainty = plane[0];
    const auto component = [&](std::size_t k) { return static_cast<double>(plane[k] / certainty); };
    const Vec3 normal{component(2), component(3), component(4)};
    const Number mean =
        plane[1] / certainty - (static_cast<Number>(normal.x) * p.x + static_cast<Number>(normal.y) * p.y +
                                static_cast<Number>(normal.z) * p.z);
    const double surface = at(surfaces_, at(contacts_.body, c)).distance(p);
    Result result;
    result.distance = std::max(0.0, static_cast<double>(mean));
    result.agreement = length(normal);
    result.plane_certainty = static_cast<double>(certainty);
    const double of_planes =
        result.distance * std::min(1.0, result.agreement / 0.9) * std::min(1.0, result.plane_certainty / 0.5);
    result.is_raised = surface > of_planes;
    result.depth = std::max(surface, of_planes);
    result.direction = normalized(normal);
    result.certainty = result.agreement * result.plane_certainty;
    const Own& own = at(own_, c);
    result.relative = result.depth / std::sqrt(own.edge_count / own.edges);
    return result;
  }

  struct MeanPlane {
    double agreement = 0.0;
    double distance = 0.0;
    Vec3 direction;
  };
  /// The mean plane of the triangles within the reach of p.
  static MeanPlane mean_plane(const AllTriangles& surface, const Vec3& p, double reach) {
    double sum = 0.0;
    double offset = 0.0;
    Vec3 normal;
    for (const Index triangle : surface.all()) {
      const std::array<Vec3, 3> corners = surface.corners(triangle);
      const Vec3 x = nearest_of_triangle(corners, p);
      if (!(length(x - p) < reach)) continue;
      const double w = std::pow(1.0 / length(x - p) - 1.0 / reach, 2);
      const Vec3 n = normalized(area_vector(corners));
      sum += w;
      offset += w * dot(x - p, n);
      normal += w * n;
    }
    if (!(sum > 0.0)) return {1.0, 0.0, {}};
    return {length(normal) / sum, offset / length(normal), normalized(normal)};
  }

  /// Interpolates depth and direction to those of deep contacts.
  void make_deep(Index c, double fraction, Result& result) const {
    const AllTriangles& surface = at(surfaces_, at(contacts_.body, c));
    const Vec3& p = at(x_, at(contacts_.point, c));
    const Vec3 r = result.direction;
    const double m =
        result.distance * std::min(1.0, result.agreement / 0.2) * std::min(1.0, result.plane_certainty / 0.7);
    double depth = m;
    Vec3 direction = r;
    const double s = surface.distance(p + m * r);
    if (surface.crossings(p, p + m * r).empty() && s > 1e-9 * m) {  // at the surface both cases are equal
      const double t = std::max(0.0, 1.0 - s / (2.0 * m));
      const Vec3 end = p + t * m * r;
      const double rest = surface.distance(end);
      const MeanPlane mean = mean_plane(surface, end, (1.0 + 0.6 * t) * rest);
      depth = t * m + (1.0 + t * std::min(0.3, 20.0 * (1.0 - mean.agreement))) * rest;
      const Vec3 exit =
          t > 0.0 ? end + std::min(mean.distance, 1.5 * rest) * mean.direction : surface.nearest(p);
      direction = normalized(exit - p);
      result.certainty *= 1.0 - fraction * (1.0 - t * std::max(0.0, 1.0 - s / (0.3 * m)));
      result.is_bent = true;
    }
    result.depth += fraction * (depth - result.depth);
    result.direction = normalized((1.0 - fraction) * r + fraction * direction);
  }

  const Bodies& bodies_;
  std::span<const Vec3> x_;
  const Contacts& contacts_;
  SurfaceNormals normals_;
  std::vector<AllTriangles> surfaces_;  ///< (n_bodies)
  std::vector<Own> own_;
  std::vector<Result> results_;
  Used used_;
};

}  // namespace palpate::test

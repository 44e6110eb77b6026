#include "contact/surface_normals.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "geometry/triangle.hpp"

namespace palpate {
namespace {

constexpr double smooth_cosine = 0.5;  // 60 degrees
constexpr double band = 0.05;  // fraction of the triangle's height over which the normal rotates at a crease

}  // namespace

SurfaceNormals::SurfaceNormals(const Bodies& bodies) {
  find_creases(bodies);
  group_corners(bodies);
}

void SurfaceNormals::find_creases(const Bodies& bodies) {
  const std::span<const Triangle> triangles = bodies.triangles();
  creases_.assign(triangles.size(), 0);
  across_.assign(bodies.triangle_neighbors().begin(), bodies.triangle_neighbors().end());
  std::vector<std::uint8_t> on_crease(bodies.points_rest().size(), 0);
  std::vector<Vec3> normals(triangles.size());
  std::ranges::transform(triangles, normals.begin(),
                         [&](const Triangle& t) { return normalized(area_vector(bodies.points_rest(), t)); });
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      Index& other = across_[t][i];
      if (other >= 0 && dot(normals[t], at(normals, other)) >= smooth_cosine) continue;
      other = -1;
      creases_[t] |= static_cast<std::uint8_t>(1U << i);
      at(on_crease, triangles[t][(i + 1) % 3]) = at(on_crease, triangles[t][(i + 2) % 3]) = 1;
    }
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (at(on_crease, triangles[t][i]) != 0) creases_[t] |= static_cast<std::uint8_t>(8U << i);
    }
  }
}

/// Groups of a point: sets of its triangles that are connected over smooth edges at the point.
void SurfaceNormals::group_corners(const Bodies& bodies) {
  const std::span<const Triangle> triangles = bodies.triangles();
  struct Corner {
    Index point;
    Index triangle;
    std::size_t corner;
  };
  std::vector<Corner> corners;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) corners.push_back({triangles[t][i], static_cast<Index>(t), i});
  }
  std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
    return std::tie(a.point, a.triangle) < std::tie(b.point, b.triangle);
  });
  corner_groups_.assign(triangles.size(), {-1, -1, -1});
  groups_of_point_.begin.assign(bodies.points_rest().size() + 1, 0);
  Index group = 0;
  std::vector<Corner> reached;
  for (const Corner& seed : corners) {
    if (at(corner_groups_, seed.triangle)[seed.corner] >= 0) continue;
    at(corner_groups_, seed.triangle)[seed.corner] = group;
    reached.assign(1, seed);
    for (std::size_t next = 0; next < reached.size(); ++next) {
      const Corner c = reached[next];
      triangles_of_group_.values.push_back(c.triangle);
      for (const std::size_t side : {(c.corner + 1) % 3, (c.corner + 2) % 3}) {
        const Index other = at(across_, c.triangle)[side];
        if (other < 0) continue;
        const Triangle& t = at(triangles, other);
        const auto corner = static_cast<std::size_t>(std::find(t.begin(), t.end(), seed.point) - t.begin());
        if (at(corner_groups_, other)[corner] >= 0) continue;
        at(corner_groups_, other)[corner] = group;
        reached.push_back({seed.point, other, corner});
      }
    }
    triangles_of_group_.begin.push_back(static_cast<Index>(triangles_of_group_.values.size()));
    groups_of_point_.values.push_back(group);
    ++at(groups_of_point_.begin, seed.point + 1);
    body_of_group_.push_back(at(bodies.body_of_point(), seed.point));
    ++group;
  }
  for (std::size_t p = 0; p + 1 < groups_of_point_.begin.size(); ++p)
    groups_of_point_.begin[p + 1] += groups_of_point_.begin[p];
  areas_.resize(triangles.size());
  group_areas_.resize(static_cast<std::size_t>(group));
  group_normals_.resize(static_cast<std::size_t>(group));
}

void SurfaceNormals::update(const parallel::Threads& threads, const Bodies& bodies,
                            std::span<const Vec3> positions, std::span<const std::uint8_t> wanted) {
  const std::span<const Triangle> triangles = bodies.triangles();
  parallel::for_each(threads, areas_.size(), 1024, [&](std::size_t t) {
    if (at(wanted, bodies.body_of(triangles[t])) != 0) areas_[t] = area_vector(positions, triangles[t]);
  });
  parallel::for_each(threads, group_areas_.size(), 512, [&](std::size_t g) {
    if (at(wanted, body_of_group_[g]) == 0) return;
    Vec3 area;
    for (const Index t : triangles_of_group_[static_cast<Index>(g)]) area += at(areas_, t);
    group_areas_[g] = area;
    group_normals_[g] = normalized(area);
  });
}

/// Distance of a point of a triangle from the nearest crease, in heights of the triangle; at most 1.
double SurfaceNormals::from_crease(Index triangle, const std::array<double, 3>& w) const {
  const unsigned creases = at(creases_, triangle);
  double distance = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((creases & (1U << i)) != 0) distance = std::min(distance, w[i]);
    if ((creases & (8U << i)) != 0) distance = std::min(distance, 1.0 - w[i]);
  }
  return distance;
}

/// \param area_of    function: area vector of a group
/// \param normal_of  function: its unit vector
template <class AreaOfGroup, class NormalOfGroup>
Vec3 SurfaceNormals::interpolated(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                  const Vec3& x, const AreaOfGroup& area_of,
                                  const NormalOfGroup& normal_of) const {
  const Triangle& t = at(bodies.triangles(), triangle);
  const std::array<Vec3, 3> corners = corners_of(positions, t);
  const Vec3 area = area_vector(corners);
  const std::array<double, 3> w = weights_in(corners, area, x);
  Vec3 smooth;
  for (std::size_t i = 0; i < 3; ++i) smooth += w[i] * normal_of(at(corner_groups_, triangle)[i]);
  Vec3 normal = smooth;
  const double from_crease = this->from_crease(triangle, w);
  if (from_crease < band) {
    Vec3 joined;
    for (std::size_t i = 0; i < 3; ++i) {
      Vec3 of_point;
      for (const Index group : groups_of_point_[t[i]]) of_point += area_of(group);
      joined += w[i] * normalized(of_point);
    }
    const double fraction = 1.0 - from_crease / band;
    normal = (1.0 - fraction) * smooth + fraction * joined;
  }
  normal = normalized(normal);
  return normal == Vec3{} ? normalized(area) : normal;
}

Vec3 SurfaceNormals::at_point(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                              const Vec3& x) const {
  return interpolated(
      bodies, positions, triangle, x, [&](Index group) { return at(group_areas_, group); },
      [&](Index group) { return at(group_normals_, group); });
}

Vec3 SurfaceNormals::at_point_now(const Bodies& bodies, std::span<const Vec3> positions, Index triangle,
                                  const Vec3& x) const {
  const auto area_of = [&](Index group) {
    Vec3 area;
    for (const Index t : triangles_of_group_[group])
      area += area_vector(positions, at(bodies.triangles(), t));
    return area;
  };
  return interpolated(bodies, positions, triangle, x, area_of,
                      [&](Index group) { return normalized(area_of(group)); });
}

void SurfaceNormals::at_points(const Bodies& bodies, std::span<const Vec3> positions,
                               std::span<const TrianglePoint> points, std::span<Vec3> normals) const {
  simd::TrianglePoints rows;
  for (std::size_t begin = 0; begin < points.size(); begin += simd::TrianglePoints::most) {
    const std::size_t n = std::min(points.size() - begin, simd::TrianglePoints::most);
    const std::span<const TrianglePoint> some = points.subspan(begin, n);
    for (std::size_t lane = 0; lane < n; ++lane) {
      rows.point.put(some[lane].x, lane);
      put_corners(bodies, positions, some[lane].triangle, rows, lane);
    }
    simd::interpolate_normals(rows, n);
    for (std::size_t lane = 0; lane < n; ++lane) {
      const auto& [triangle, x] = some[lane];
      normals[begin + lane] = is_interpolated(triangle, rows, lane)
                                  ? Vec3{rows.normal.x[lane], rows.normal.y[lane], rows.normal.z[lane]}
                                  : at_point(bodies, positions, triangle, x);
    }
  }
}

bool SurfaceNormals::is_interpolated(Index triangle, const simd::TrianglePoints& points,
                                     std::size_t lane) const {
  if (at(creases_, triangle) != 0 &&
      from_crease(triangle, {points.weight[0][lane], points.weight[1][lane], points.weight[2][lane]}) < band)
    return false;
  return points.normal.x[lane] != 0.0 || points.normal.y[lane] != 0.0 || points.normal.z[lane] != 0.0;
}

}  // namespace palpate

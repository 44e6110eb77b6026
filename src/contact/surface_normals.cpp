#include "contact/surface_normals.hpp"

#include <algorithm>
#include <array>
#include <tuple>

#include "geometry/triangle.hpp"
#include "mesh/grouped.hpp"

namespace palpate {
namespace {

constexpr std::size_t normal_grain = 512;

std::size_t corner_of(const Triangle& triangle, Index point) {
  return static_cast<std::size_t>(std::find(triangle.begin(), triangle.end(), point) - triangle.begin());
}

/// The corners of triangles at each point, in the order of their triangles; corner i of triangle t is 3 t +
/// i.
Rows corners_of_points(const Bodies& bodies) {
  const std::span<const Triangle> triangles = bodies.triangles();
  return grouped(3 * triangles.size(), bodies.points_rest().size(),
                 [&](std::size_t corner) { return std::array{triangles[corner / 3][corner % 3]}; });
}

}  // namespace

struct SurfaceNormals::Fan {
  Index body;
  Index length;  ///< number of triangles
  Index number;  ///< by point, then by the first triangle
  Index group;   ///< number of the first fan that is connected with it
  Index begin;   ///< place of its triangles in a list
};

SurfaceNormals::SurfaceNormals(const Bodies& bodies) {
  const SurfaceJoints joints(bodies);
  const std::span<const Triangle> triangles = bodies.triangles();
  for (std::size_t t = 0; t < triangles.size(); ++t)
    triangles_.push_back({triangles[t], {-1, -1, -1}, joints.creases(static_cast<Index>(t))});
  find_fans(bodies, joints);
}

/// Finds the fans of all corners: from the triangle with the lowest number over its smooth edges, breadth
/// first. Sums over a fan have this order. Then their groups, in the same way.
void SurfaceNormals::find_fans(const Bodies& bodies, const SurfaceJoints& joints) {
  const std::span<const Triangle> triangles = bodies.triangles();
  const Rows corners = corners_of_points(bodies);
  std::vector<Fan> fans;
  std::vector<Index> reached;  // of all fans, as in `corners`
  std::vector<Index> connected;
  std::vector<Index> groups(3 * triangles.size(), -1);  // of corners
  fans_of_point_.begin.assign(1, 0);
  const auto fan_of = [&](Index corner) -> Index& {
    return at(triangles_, corner / 3).fans[static_cast<std::size_t>(corner % 3)];
  };
  // Marks a corner and those that are connected with it, and appends them to a list.
  const auto mark_all = [&](Index seed, Index mark, std::vector<Index>& list, auto&& mark_of, auto&& over) {
    const std::size_t begin = list.size();
    const auto add = [&](Index corner) {
      mark_of(corner) = mark;
      list.push_back(corner);
    };
    add(seed);
    const Index point = at(triangles, seed / 3)[static_cast<std::size_t>(seed % 3)];
    for (std::size_t n = begin; n < list.size(); ++n) {
      const Index triangle = list[n] / 3;
      const auto corner = static_cast<std::size_t>(list[n] % 3);
      for (const std::size_t side : {(corner + 1) % 3, (corner + 2) % 3}) {
        const Index other = over(triangle, side, point);
        if (other < 0) continue;
        const Index found = 3 * other + static_cast<Index>(corner_of(at(triangles, other), point));
        if (mark_of(found) < 0) add(found);
      }
    }
  };
  for (Index point = 0; point + 1 < static_cast<Index>(corners.begin.size()); ++point) {
    for (const Index seed : corners[point]) {
      if (fan_of(seed) >= 0) continue;
      const auto number = static_cast<Index>(fans.size());
      const auto begin = static_cast<Index>(reached.size());
      mark_all(seed, number, reached, fan_of,
               [&](Index t, std::size_t side, Index p) { return joints.smooth_over(t, side, p); });
      if (at(groups, seed) < 0) {
        connected.clear();
        mark_all(
            seed, number, connected, [&](Index corner) -> Index& { return at(groups, corner); },
            [&](Index t, std::size_t side, Index) { return joints.over(t, side); });
      }
      fans.push_back({at(bodies.body_of_point(), point), static_cast<Index>(reached.size()) - begin, number,
                      at(groups, seed), begin});
    }
    fans_of_point_.begin.push_back(static_cast<Index>(fans.size()));
  }
  number_fans(fans, reached);
}

/// Numbers fans of one length one after the other, so that SIMD lanes have equal work.
void SurfaceNormals::number_fans(std::vector<Fan>& fans, std::span<const Index> corners) {
  std::ranges::sort(fans, {}, [](const Fan& fan) { return std::tuple(fan.body, fan.length, fan.number); });
  fans_of_point_.values.resize(fans.size());
  fan_begin_.assign(1, 0);
  for (const Fan& fan : fans) {
    at(fans_of_point_.values, fan.number) = static_cast<Index>(fan_begin_.size()) - 1;
    group_of_fan_.push_back(fan.group);
    for (Index n = fan.begin; n < fan.begin + fan.length; ++n)
      fan_triangles_.push_back(at(triangles_, at(corners, n) / 3).corners);
    fan_begin_.push_back(static_cast<Index>(fan_triangles_.size()));
  }
  for (simd::SmoothTriangle& triangle : triangles_)
    for (Index& fan : triangle.fans) fan = at(fans_of_point_.values, fan);
  wanted_.resize(fans.size());
  areas_.resize(fans.size());
  units_.resize(fans.size());
}

void SurfaceNormals::prepare(const parallel::Threads& threads, std::span<const Vec3> positions,
                             std::span<const Crossing> crossings) {
  wanted_.forget();
  parallel::for_chunks(threads, crossings.size(), 8 * normal_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         const WantedItems::FirstWanted fans(wanted_);
                         const simd::SmoothTriangle* const triangles = triangles_.data();
                         for (const Crossing& crossing : crossings.subspan(begin, end - begin)) {
                           const auto [a, b, c] = triangles[crossing.triangle].fans;
                           fans.want(a);
                           fans.want(b);
                           fans.want(c);
                         }
                       });
  prepare_wanted(threads, positions);
}

void SurfaceNormals::want(Index triangle) {
  for (const Index fan : at(triangles_, triangle).fans) wanted_.want(fan);
}

void SurfaceNormals::prepare_wanted(const parallel::Threads& threads, std::span<const Vec3> positions) {
  const std::span<const Index> fans = wanted_.list(threads);
  parallel::for_chunks(threads, fans.size(), normal_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::find_fan_normals({positions, fan_begin_, fan_triangles_},
                                                fans.subspan(begin, end - begin), areas_, units_);
                       });
}

/// Distance of a point of a triangle from the nearest crease of one kind, in widths of its band; at most 1.
/// \param first_bit  of the kind of crease
double SurfaceNormals::from_crease(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                   double distance, unsigned first_bit) const {
  const auto& [corners, fans, all_creases] = at(triangles_, triangle);
  const std::uint32_t creases = (all_creases >> first_bit) & 63U;
  if (creases == 0) return 1.0;
  const std::array<Vec3, 3> x = corners_of(positions, corners);
  const double twice_area = length(area_vector(x));
  double nearest = 1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    // distance / height of corner i
    const double width = std::min(band, distance * length(x[(i + 2) % 3] - x[(i + 1) % 3]) / twice_area);
    const bool at_side = (creases & (1U << i)) != 0;
    const bool at_corner = (creases & (8U << i)) != 0;
    if (at_side && w[i] < width) nearest = std::min(nearest, w[i] / width);
    if (at_corner && 1.0 - w[i] < width) nearest = std::min(nearest, (1.0 - w[i]) / width);
  }
  return nearest;
}

SurfaceNormals::Weights SurfaceNormals::weights(std::span<const Vec3> positions, Index triangle,
                                                const Vec3& x) const {
  const std::array<Vec3, 3> corners = corners_of(positions, at(triangles_, triangle).corners);
  return weights_in(corners, area_vector(corners), x);
}

/// \param area_of  function: sum of the area vectors of a fan
/// \param unit_of  function: its unit vector
template <class AreaOfFan, class UnitOfFan>
Vec3 SurfaceNormals::interpolated(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                  double distance, const AreaOfFan& area_of, const UnitOfFan& unit_of) const {
  const simd::SmoothTriangle& t = at(triangles_, triangle);
  // The mean of those fans at a corner that count.
  const auto mean_at = [&](std::size_t i, auto&& counts) {
    Vec3 area;
    Index last = -1;
    int n = 0;
    for (const Index fan : fans_of_point_[t.corners[i]]) {
      if (!counts(fan)) continue;
      area += area_of(fan);
      last = fan;
      ++n;
    }
    return n > 1 ? normalized(area) : unit_of(last);
  };
  const auto blended = [&](const Vec3& normal, double from_crease, auto&& normal_at) {
    Vec3 joined;
    for (std::size_t i = 0; i < 3; ++i) joined += w[i] * normal_at(i);
    const double fraction = 1.0 - from_crease;
    return (1.0 - fraction) * normal + fraction * joined;
  };
  Vec3 normal;
  for (std::size_t i = 0; i < 3; ++i) normal += w[i] * unit_of(t.fans[i]);
  if (const double from = from_crease(positions, triangle, w, distance, simd::SmoothTriangle::hollow_bits);
      from < 1.0) {
    normal = blended(normal, from, [&](std::size_t i) {
      const Index group = at(group_of_fan_, t.fans[i]);
      return mean_at(i, [&](Index fan) { return at(group_of_fan_, fan) == group; });
    });
  }
  if (const double from = from_crease(positions, triangle, w, distance, simd::SmoothTriangle::sharp_bits);
      from < 1.0)
    normal = blended(normal, from, [&](std::size_t i) { return mean_at(i, [](Index) { return true; }); });
  normal = normalized(normal);
  return normal == Vec3{} ? normalized(area_vector(positions, t.corners)) : normal;
}

/// Sum of the area vectors of a fan's triangles, as simd::find_fan_normals() computes it.
Vec3 SurfaceNormals::area_of_fan(std::span<const Vec3> positions, Index fan) const {
  Vec3 area;
  const auto begin = static_cast<std::size_t>(at(fan_begin_, fan));
  const auto end = static_cast<std::size_t>(at(fan_begin_, fan + 1));
  for (const Triangle& triangle : std::span(fan_triangles_).subspan(begin, end - begin))
    area += area_vector(positions, triangle);
  return area;
}

Vec3 SurfaceNormals::at_weights(std::span<const Vec3> positions, Index triangle, const Weights& w,
                                double distance) const {
  const auto area_of = [&](Index fan) {
    return wanted_.is_listed(fan) ? at(areas_, fan) : area_of_fan(positions, fan);
  };
  return interpolated(positions, triangle, w, distance, area_of, [&](Index fan) { return at(units_, fan); });
}

Vec3 SurfaceNormals::at_point_now(std::span<const Vec3> positions, Index triangle, const Vec3& x,
                                  double distance) const {
  return interpolated(
      positions, triangle, weights(positions, triangle, x), distance,
      [&](Index fan) { return area_of_fan(positions, fan); },
      [&](Index fan) { return normalized(area_of_fan(positions, fan)); });
}

void SurfaceNormals::at_points(std::span<const Vec3> positions, std::span<const simd::PointOfTriangle> points,
                               std::span<Vec3> normals, std::span<simd::Doubtful> scratch) const {
  const std::size_t doubtful = simd::find_normals(smooth(positions), points, normals, scratch);
  for (const simd::Doubtful& d : scratch.first(doubtful)) {
    const auto& [triangle, x, distance] = points[d.item];
    normals[d.item] = at_weights(positions, triangle, d.weights, distance);
  }
}

}  // namespace palpate

#include "simd/triangle_normals.hpp"

#include <algorithm>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/triangle_normals.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/vector_gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using DoubleMask = hn::Mask<Doubles>;

/// v / |v|, or zero where its length is zero or not finite.
HWY_INLINE Vector unit(const Vector& v) {
  const Double length = hn::Sqrt(dot(v, v));
  const auto is_length = hn::And(hn::Gt(length, hn::Zero(doubles)),
                                 hn::Le(length, hn::Set(doubles, std::numeric_limits<double>::max())));
  const Vector u = scaled(hn::Div(hn::Set(doubles, 1.0), length), v);
  return {hn::IfThenElseZero(is_length, u.x), hn::IfThenElseZero(is_length, u.y),
          hn::IfThenElseZero(is_length, u.z)};
}

HWY_INLINE void store_vectors(const Vector& v, Vec3* to, const std::array<Index, double_lanes>& places) {
  alignas(64) double rows[3][double_lanes];
  hn::Store(v.x, doubles, rows[0]);
  hn::Store(v.y, doubles, rows[1]);
  hn::Store(v.z, doubles, rows[2]);
  for (std::size_t lane = 0; lane < double_lanes; ++lane)
    to[places[lane]] = {rows[0][lane], rows[1][lane], rows[2][lane]};
}

/// The fans of one block, one per lane.
struct FanLanes {
  const Vec3* positions;
  std::array<const Triangle*, double_lanes> triangles;
  std::array<std::size_t, double_lanes> last;
  Double length;

  /// Sum of the area vectors. Shorter fans repeat their last triangle, which is not added.
  template <bool same_length>
  HWY_INLINE Vector area(std::size_t steps) const {
    const Double zero = hn::Zero(doubles);
    Vector total{zero, zero, zero};
    for (std::size_t step = 0; step < steps; ++step) {
      const auto triangle = [&](std::size_t lane) HWY_ATTR -> const Triangle& {
        return triangles[lane][same_length ? step : std::min(step, last[lane])];
      };
      const Vector a = load_vectors([&](std::size_t lane)
                                        HWY_ATTR -> const Vec3& { return positions[triangle(lane)[0]]; });
      const Vector b = load_vectors([&](std::size_t lane)
                                        HWY_ATTR -> const Vec3& { return positions[triangle(lane)[1]]; });
      const Vector c = load_vectors([&](std::size_t lane)
                                        HWY_ATTR -> const Vec3& { return positions[triangle(lane)[2]]; });
      Vector area = cross(difference(b, a), difference(c, a));
      if constexpr (!same_length) {
        const auto has = hn::Gt(length, hn::Set(doubles, static_cast<double>(step)));
        area = {hn::IfThenElseZero(has, area.x), hn::IfThenElseZero(has, area.y),
                hn::IfThenElseZero(has, area.z)};
      }
      total = sum(total, area);
    }
    return total;
  }
};

}  // namespace

void find_fan_normals(const Fans& fans, std::span<const Index> which, std::span<Vec3> areas,
                      std::span<Vec3> units) {
  const Index* begin = fans.begin.data();
  for (std::size_t i = 0; i < which.size(); i += double_lanes) {
    const Block block{i, which.size() - 1};
    FanLanes lanes{fans.positions.data(), {}, {}, hn::Zero(doubles)};
    std::array<Index, double_lanes> fan;
    alignas(64) double length[double_lanes];
    std::size_t least = std::numeric_limits<std::size_t>::max();
    std::size_t most = 0;
    for (std::size_t lane = 0; lane < double_lanes; ++lane) {
      const Index f = fan[lane] = which[block.item(lane)];
      const auto size = static_cast<std::size_t>(begin[f + 1] - begin[f]);
      lanes.triangles[lane] = fans.triangles.data() + begin[f];
      lanes.last[lane] = size - 1;
      length[lane] = static_cast<double>(size);
      least = std::min(least, size);
      most = std::max(most, size);
    }
    lanes.length = hn::Load(doubles, length);
    const Vector area = least == most ? lanes.area<true>(most) : lanes.area<false>(most);
    store_vectors(area, areas.data(), fan);
    store_vectors(unit(area), units.data(), fan);
  }
}

namespace {

struct NormalLanes {
  Vector unit;
  Double weight[3];
  DoubleMask near_side;
};

/// The triangles of one block, one per lane.
struct TriangleLanes {
  const Vec3* positions;
  const Vec3* normals;
  double margin;
  std::array<const SmoothTriangle*, double_lanes> triangle;

  /// Interpolates the normals of the corners.
  HWY_INLINE NormalLanes normals_at(const Vector& x) const {
    const Double zero = hn::Zero(doubles);
    const Vector corner[3] = {load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& {
                                return positions[triangle[lane]->corners[0]];
                              }),
                              load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& {
                                return positions[triangle[lane]->corners[1]];
                              }),
                              load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& {
                                return positions[triangle[lane]->corners[2]];
                              })};
    const Vector area = cross(difference(corner[1], corner[0]), difference(corner[2], corner[0]));
    const Vector to[3] = {difference(corner[0], x), difference(corner[1], x), difference(corner[2], x)};
    const Vector part[3] = {cross(to[1], to[2]), cross(to[2], to[0]), cross(to[0], to[1])};
    NormalLanes found;
    Double total = zero;
    for (std::size_t i = 0; i < 3; ++i) {
      const Double w = dot(part[i], area);
      found.weight[i] = hn::IfThenElseZero(hn::Gt(w, zero), w);
      total = hn::Add(total, found.weight[i]);
    }
    const auto has_area = hn::Gt(total, zero);
    Vector n{zero, zero, zero};
    for (std::size_t i = 0; i < 3; ++i) {
      Double& w = found.weight[i];
      w = hn::IfThenElse(has_area, hn::Div(w, total), hn::Set(doubles, 1.0 / 3.0));
      const auto place = [&](std::size_t lane)
                             HWY_ATTR -> const Vec3& { return normals[triangle[lane]->fans[i]]; };
      n = sum(n, scaled(w, load_vectors(place)));
    }
    const Double least = hn::Min(hn::Min(found.weight[0], found.weight[1]), found.weight[2]);
    const Double most = hn::Max(hn::Max(found.weight[0], found.weight[1]), found.weight[2]);
    found.unit = unit(n);
    found.near_side =
        hn::Or(hn::Lt(least, hn::Set(doubles, margin)), hn::Gt(most, hn::Set(doubles, 1.0 - margin)));
    return found;
  }
};

bool is_near_crease(std::uint32_t creases, const std::array<double, 3>& weights, double margin) {
  std::uint32_t near = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    near |= (weights[i] < margin ? 1U : 0U) << i;
    near |= (1.0 - weights[i] < margin ? 8U : 0U) << i;
  }
  return (((creases >> SmoothTriangle::sharp_bits) | (creases >> SmoothTriangle::hollow_bits)) & near) != 0;
}

/// Appends the doubtful ones of a block.
template <class BlockOfPoints>
HWY_INLINE std::size_t list_doubtful(const TriangleLanes& lanes, const NormalLanes& normal,
                                     DoubleMask is_valid, const BlockOfPoints& block, Doubtful* list,
                                     std::size_t count) {
  const auto is_doubtful = hn::Or(normal.near_side, hn::Not(is_valid));
  if (hn::AllFalse(doubles, is_doubtful)) return count;
  alignas(64) double weight[3][double_lanes];
  for (std::size_t i = 0; i < 3; ++i) hn::Store(normal.weight[i], doubles, weight[i]);
  const std::uint32_t valid = bits_of(is_valid);
  for (std::uint32_t left = bits_of(is_doubtful); left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    if (!block.contains(lane)) break;
    const bool only_near = ((valid >> lane) & 1U) != 0;
    const std::uint32_t creases = lanes.triangle[lane]->creases;
    if (only_near && creases == 0) continue;
    const std::array<double, 3> weights{weight[0][lane], weight[1][lane], weight[2][lane]};
    if (only_near && !is_near_crease(creases, weights, lanes.margin)) continue;
    list[count++] = {static_cast<std::uint32_t>(block.begin + lane), only_near, weights};
  }
  return count;
}

HWY_INLINE DoubleMask is_nonzero(const Vector& unit) {
  return hn::Gt(dot(unit, unit), hn::Zero(doubles));
}

}  // namespace

std::size_t find_normals(const SmoothTriangles& triangles, std::span<const PointOfTriangle> points,
                         std::span<Vec3> normals, std::span<Doubtful> doubtful) {
  std::size_t count = 0;
  for (std::size_t begin = 0; begin < points.size(); begin += double_lanes) {
    const Block block{begin, points.size() - 1};
    TriangleLanes lanes{triangles.positions.data(), triangles.normals.data(), triangles.margin, {}};
    for (std::size_t lane = 0; lane < double_lanes; ++lane)
      lanes.triangle[lane] = triangles.triangles.data() + points[block.item(lane)].triangle;
    const NormalLanes n = lanes.normals_at(
        load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& { return points[block.item(lane)].x; }));
    alignas(64) double rows[3][double_lanes];
    hn::Store(n.unit.x, doubles, rows[0]);
    hn::Store(n.unit.y, doubles, rows[1]);
    hn::Store(n.unit.z, doubles, rows[2]);
    for (std::size_t lane = 0; lane < double_lanes; ++lane)
      normals[block.item(lane)] = {rows[0][lane], rows[1][lane], rows[2][lane]};
    count = list_doubtful(lanes, n, is_nonzero(n.unit), block, doubtful.data(), count);
  }
  return count;
}

std::size_t find_planes(const CrossedEdges& edges, const SmoothTriangles& triangles,
                        std::span<const Crossing> crossings, std::span<WeightedPlane> planes,
                        std::span<Doubtful> doubtful) {
  const Double one = hn::Set(doubles, 1.0);
  const Vec3* positions = triangles.positions.data();
  const BorderEdge* border_edges = edges.edges.data();
  const Index* points = edges.point_of_contact.data();
  std::size_t count = 0;
  for_each_block(crossings.size(), [&](const auto& block) HWY_ATTR {
    TriangleLanes lanes{positions, triangles.normals.data(), triangles.margin, {}};
    std::array<const BorderEdge*, double_lanes> edge;
    alignas(64) double parameter[double_lanes];
    for (std::size_t lane = 0; lane < double_lanes; ++lane) {
      const Crossing& crossing = crossings[block.item(lane)];
      edge[lane] = border_edges + crossing.border_edge;
      lanes.triangle[lane] = triangles.triangles.data() + crossing.triangle;
      parameter[lane] = crossing.parameter;
    }
    const Vector p = load_vectors(
        [&](std::size_t lane) HWY_ATTR -> const Vec3& { return positions[points[edge[lane]->contact]]; });
    const Vector e = difference(load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& {
                                  return positions[edge[lane]->free_point];
                                }),
                                p);
    const Double t = hn::Load(doubles, parameter);
    const NormalLanes n = lanes.normals_at(sum(p, scaled(t, e)));
    const Double l2 = dot(e, e);
    const Double inverse = hn::Div(one, l2);
    const Double weight = hn::Sub(hn::Div(one, hn::Mul(t, t)), hn::Set(doubles, edges.lost));
    const Double depth = hn::Mul(hn::Mul(weight, t), dot(e, n.unit));
    const Vector weighted = scaled(weight, n.unit);
    const Double nearest = hn::IfThenElse(hn::Lt(t, one), t, one);
    const auto store = [&](Double first, Double second, std::size_t offset) HWY_ATTR {
      store_pairs({first, second},
                  [&](std::size_t lane) HWY_ATTR { return planes[block.item(lane)].sums.data() + offset; });
    };
    store(hn::Mul(inverse, depth), hn::Mul(inverse, weighted.x), 0);
    store(hn::Mul(inverse, weighted.y), hn::Mul(inverse, weighted.z), 2);
    store(hn::Mul(inverse, weight), inverse, 4);
    store_pairs({hn::Mul(nearest, hn::Sqrt(l2)), hn::Zero(doubles)},
                [&](std::size_t lane) HWY_ATTR { return &planes[block.item(lane)].distance; });
    const auto is_usual =
        hn::And(hn::Ge(l2, hn::Set(doubles, edges.shortest)), hn::Ge(t, hn::Set(doubles, edges.nearest)));
    count = list_doubtful(lanes, n, hn::And(is_usual, is_nonzero(n.unit)), block, doubtful.data(), count);
  });
  return count;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_fan_normals);
HWY_EXPORT(find_normals);
HWY_EXPORT(find_planes);

void find_fan_normals(const Fans& fans, std::span<const Index> which, std::span<Vec3> areas,
                      std::span<Vec3> units) {
  HWY_DYNAMIC_DISPATCH(find_fan_normals)(fans, which, areas, units);
}

std::size_t find_normals(const SmoothTriangles& triangles, std::span<const PointOfTriangle> points,
                         std::span<Vec3> normals, std::span<Doubtful> doubtful) {
  return HWY_DYNAMIC_DISPATCH(find_normals)(triangles, points, normals, doubtful);
}

std::size_t find_planes(const CrossedEdges& edges, const SmoothTriangles& triangles,
                        std::span<const Crossing> crossings, std::span<WeightedPlane> planes,
                        std::span<Doubtful> doubtful) {
  return HWY_DYNAMIC_DISPATCH(find_planes)(edges, triangles, crossings, planes, doubtful);
}

}  // namespace palpate::simd
#endif

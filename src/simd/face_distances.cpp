#include "simd/face_distances.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/face_distances.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/vector_gather-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

/// Corners of tets relative to a point, one tet per lane.
struct CornerLanes {
  Vector to[4];
  Double squared[4];
};

/// An edge of the tets.
struct EdgeLanes {
  Vector product;  ///< cross product of its ends
  Double squared;  ///< distance from the part of the line between the ends; infinite: an end is nearer
};

HWY_INLINE EdgeLanes edge_of(const CornerLanes& corners, std::size_t i, std::size_t j) {
  const Double zero = hn::Zero(doubles);
  const Vector edge = difference(corners.to[j], corners.to[i]);
  const Vector product = cross(corners.to[i], corners.to[j]);
  const Double l2 = dot(edge, edge);
  const Double along = hn::Sub(zero, dot(corners.to[i], edge));
  const auto is_between = hn::And(hn::Gt(along, zero), hn::Lt(along, l2));
  const Double squared = hn::Div(dot(product, product), l2);
  return {product,
          hn::IfThenElse(is_between, squared, hn::Set(doubles, std::numeric_limits<double>::infinity()))};
}

HWY_INLINE Vector negative(const Vector& v) {
  const Double zero = hn::Zero(doubles);
  return {hn::Sub(zero, v.x), hn::Sub(zero, v.y), hn::Sub(zero, v.z)};
}

HWY_INLINE Double less(Double a, Double b) {
  return hn::IfThenElse(hn::Lt(b, a), b, a);
}

/// Squared distance from a face: from its plane if the foot is inside, else from the nearest edge or corner.
/// \param ij  cross product of corners i and j, and so on
HWY_INLINE Double squared_distance(const Vector& to_corner, const Vector& ij, const Vector& jk,
                                   const Vector& ki, Double from_rim) {
  const Double zero = hn::Zero(doubles);
  const Vector normal = sum(sum(ij, jk), ki);
  const Double height = dot(to_corner, normal);
  const Double n2 = dot(normal, normal);
  const auto is_left = [&](const Vector& side) HWY_ATTR { return hn::Ge(dot(side, normal), zero); };
  const auto is_inside = hn::And(hn::And(is_left(ij), is_left(jk)), hn::And(is_left(ki), hn::Gt(n2, zero)));
  return hn::IfThenElse(is_inside, hn::Div(hn::Mul(height, height), n2), from_rim);
}

}  // namespace

void find_face_distances(std::span<const Vec3> positions, std::span<const Tet> tets,
                         std::span<const Vec3> points, std::span<const PointAndTet> pairs,
                         std::span<const std::uint32_t> which, std::span<std::array<double, 4>> squared) {
  const Vec3* at = positions.data();
  for (std::size_t begin = 0; begin < which.size(); begin += double_lanes) {
    const Block block{begin, which.size() - 1};
    std::array<const Tet*, double_lanes> tet;
    std::array<const Vec3*, double_lanes> point;
    std::array<double*, double_lanes> distances;
    for (std::size_t lane = 0; lane < double_lanes; ++lane) {
      const std::uint32_t pair = which[block.item(lane)];
      tet[lane] = tets.data() + pairs[pair].tet;
      point[lane] = points.data() + pairs[pair].point;
      distances[lane] = squared[pair].data();
    }
    const Vector p = load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& { return *point[lane]; });
    CornerLanes c;
    for (std::size_t i = 0; i < 4; ++i) {
      c.to[i] = difference(
          load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& { return at[(*tet[lane])[i]]; }), p);
      c.squared[i] = dot(c.to[i], c.to[i]);
    }
    const EdgeLanes e01 = edge_of(c, 0, 1);
    const EdgeLanes e02 = edge_of(c, 0, 2);
    const EdgeLanes e03 = edge_of(c, 0, 3);
    const EdgeLanes e12 = edge_of(c, 1, 2);
    const EdgeLanes e13 = edge_of(c, 1, 3);
    const EdgeLanes e23 = edge_of(c, 2, 3);
    const auto rim = [&](std::size_t i, std::size_t j, std::size_t k, const EdgeLanes& ij,
                         const EdgeLanes& jk, const EdgeLanes& ik) HWY_ATTR {
      return less(less(less(c.squared[i], c.squared[j]), less(c.squared[k], ij.squared)),
                  less(jk.squared, ik.squared));
    };
    const Vector p13 = negative(e13.product);
    const Vector p03 = negative(e03.product);
    const Vector p02 = negative(e02.product);
    const Double f0 = squared_distance(c.to[1], e12.product, e23.product, p13, rim(1, 2, 3, e12, e23, e13));
    const Double f1 = squared_distance(c.to[0], e02.product, e23.product, p03, rim(0, 2, 3, e02, e23, e03));
    const Double f2 = squared_distance(c.to[0], e01.product, e13.product, p03, rim(0, 1, 3, e01, e13, e03));
    const Double f3 = squared_distance(c.to[0], e01.product, e12.product, p02, rim(0, 1, 2, e01, e12, e02));
    store_pairs({f0, f1}, [&](std::size_t lane) HWY_ATTR { return distances[lane]; });
    store_pairs({f2, f3}, [&](std::size_t lane) HWY_ATTR { return distances[lane] + 2; });
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_face_distances);

void find_face_distances(std::span<const Vec3> positions, std::span<const Tet> tets,
                         std::span<const Vec3> points, std::span<const PointAndTet> pairs,
                         std::span<const std::uint32_t> which, std::span<std::array<double, 4>> squared) {
  HWY_DYNAMIC_DISPATCH(find_face_distances)(positions, tets, points, pairs, which, squared);
}

}  // namespace palpate::simd
#endif

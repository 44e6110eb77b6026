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

/// Squared distance from the part of an edge between its ends; infinite: an end is nearer. Vectors are not
/// put into structs with others, since GCC would copy them piece by piece.
/// \param product  cross product of the ends
HWY_INLINE Double from_edge(const Vector& a, const Vector& b, const Vector& product) {
  const Double zero = hn::Zero(doubles);
  const Vector edge = difference(b, a);
  const Double l2 = dot(edge, edge);
  const Double along = hn::Sub(zero, dot(a, edge));
  const auto is_between = hn::And(hn::Gt(along, zero), hn::Lt(along, l2));
  const Double squared = hn::Div(dot(product, product), l2);
  return hn::IfThenElse(is_between, squared, hn::Set(doubles, std::numeric_limits<double>::infinity()));
}

HWY_INLINE Double less(Double a, Double b) {
  return hn::IfThenElse(hn::Lt(b, a), b, a);
}
HWY_INLINE Double least(Double a, Double b, Double c, Double ab, Double bc, Double ac) {
  return less(less(less(a, b), less(c, ab)), less(bc, ac));
}

/// Squared distance from a face: from its plane if the foot is inside, else from the nearest edge or corner.
/// \param ij  cross product of corners i and j, and so on
HWY_INLINE Double squared_distance(const Vector& to_corner, const Vector& ij, const Vector& jk,
                                   const Vector& ik, Double from_rim) {
  const Double zero = hn::Zero(doubles);
  const Vector normal = difference(sum(ij, jk), ik);
  const Double height = dot(to_corner, normal);
  const Double n2 = dot(normal, normal);
  const auto is_left = [&](const Vector& side) HWY_ATTR { return hn::Ge(dot(side, normal), zero); };
  const auto is_right = hn::Le(dot(ik, normal), zero);
  const auto is_inside = hn::And(hn::And(is_left(ij), is_left(jk)), hn::And(is_right, hn::Gt(n2, zero)));
  return hn::IfThenElse(is_inside, hn::Div(hn::Mul(height, height), n2), from_rim);
}

}  // namespace

void find_face_distances(std::span<const Vec3> positions, std::span<const Tet> tets,
                         std::span<const Vec3> points, std::span<const PointAndTet> pairs,
                         std::span<const std::uint32_t> which, std::span<std::array<double, 4>> squared) {
  const Vec3* at = positions.data();
  for_each_block(which.size(), [&](const auto& block) HWY_ATTR {
    std::array<std::uint32_t, double_lanes> pair;
    std::array<Tet, double_lanes> tet;  // copies: GCC would keep pointers to them in vectors
    for (std::size_t lane = 0; lane < double_lanes; ++lane) {
      pair[lane] = which[block.item(lane)];
      tet[lane] = tets[static_cast<std::size_t>(pairs[pair[lane]].tet)];
    }
    const Vector p = load_vectors([&](std::size_t lane)
                                      HWY_ATTR -> const Vec3& { return points[pairs[pair[lane]].point]; });
    const auto corner = [&](std::size_t i) HWY_ATTR {
      return difference(
          load_vectors([&](std::size_t lane) HWY_ATTR -> const Vec3& { return at[tet[lane][i]]; }), p);
    };
    const Vector c0 = corner(0);
    const Vector c1 = corner(1);
    const Vector c2 = corner(2);
    const Vector c3 = corner(3);
    const Vector c01 = cross(c0, c1);
    const Vector c02 = cross(c0, c2);
    const Vector c03 = cross(c0, c3);
    const Vector c12 = cross(c1, c2);
    const Vector c13 = cross(c1, c3);
    const Vector c23 = cross(c2, c3);
    const Double d0 = dot(c0, c0);
    const Double d1 = dot(c1, c1);
    const Double d2 = dot(c2, c2);
    const Double d3 = dot(c3, c3);
    const Double d01 = from_edge(c0, c1, c01);
    const Double d02 = from_edge(c0, c2, c02);
    const Double d03 = from_edge(c0, c3, c03);
    const Double d12 = from_edge(c1, c2, c12);
    const Double d13 = from_edge(c1, c3, c13);
    const Double d23 = from_edge(c2, c3, c23);
    const Double f0 = squared_distance(c1, c12, c23, c13, least(d1, d2, d3, d12, d23, d13));
    const Double f1 = squared_distance(c0, c02, c23, c03, least(d0, d2, d3, d02, d23, d03));
    const Double f2 = squared_distance(c0, c01, c13, c03, least(d0, d1, d3, d01, d13, d03));
    const Double f3 = squared_distance(c0, c01, c12, c02, least(d0, d1, d2, d01, d12, d02));
    store_pairs({f0, f1}, [&](std::size_t lane) HWY_ATTR { return squared[pair[lane]].data(); });
    store_pairs({f2, f3}, [&](std::size_t lane) HWY_ATTR { return squared[pair[lane]].data() + 2; });
  });
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

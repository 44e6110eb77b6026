#include "simd/crossing_query.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/crossing_query.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/cluster_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Negative in the lanes where the interval between a and b (in either order) does not meet [lower, upper].
HWY_INLINE Int apart(const std::int32_t* a, const std::int32_t* b, std::uint32_t e, Int lower, Int upper) {
  const Int x = hn::LoadU(ints, a + e);
  const Int y = hn::LoadU(ints, b + e);
  return hn::Or(hn::Sub(hn::Max(x, y), lower), hn::Sub(upper, hn::Min(x, y)));
}

void filter_edges(const EdgeRows& edges, ClusterBlock& block) {
  const Int first_places = hn::Iota(ints, 0);
  std::size_t count = 0;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const ClusterBox& box = block.box[c];
    const Int x0 = hn::Set(ints, box.lower.x);
    const Int y0 = hn::Set(ints, box.lower.y);
    const Int z0 = hn::Set(ints, box.lower.z);
    const Int x1 = hn::Set(ints, box.upper.x);
    const Int y1 = hn::Set(ints, box.upper.y);
    const Int z1 = hn::Set(ints, box.upper.z);
    const Int body = hn::Set(ints, block.cluster[c]->body);
    block.first_candidate[c] = static_cast<std::uint32_t>(count);
    for (std::uint32_t r = block.first_row[c]; r < block.first_row[c + 1]; ++r) {
      const PointRange row = block.rows[r];
      for (std::uint32_t e = row.begin; e < row.end; e += static_cast<std::uint32_t>(lanes())) {
        const Int place = hn::Add(first_places, hn::Set(ints, static_cast<std::int32_t>(e)));
        const Int beyond = hn::Sub(hn::Set(ints, static_cast<std::int32_t>(row.end - 1)), place);
        const Int out =
            hn::Or(hn::Or(apart(edges.a.x, edges.b.x, e, x0, x1), apart(edges.a.y, edges.b.y, e, y0, y1)),
                   hn::Or(apart(edges.a.z, edges.b.z, e, z0, z1), beyond));
        const auto is_for = hn::Eq(hn::LoadU(ints, edges.body + e), body);
        const auto keep = hn::And(is_for, hn::MaskFromVec(hn::BroadcastSignBit(hn::Not(out))));
        count += store_kept(place, keep, block.candidate.data() + count);
      }
    }
  }
  block.first_candidate[block.clusters] = static_cast<std::uint32_t>(count);
}

/// One number for each of 16 triangles.
using Lanes16 = std::array<float, Cluster::most_primitives>;

struct Stored {
  alignas(64) Lanes16 x;
  alignas(64) Lanes16 y;
  alignas(64) Lanes16 z;
  HWY_INLINE void store(const Vector& v, std::size_t lane) {
    hn::Store(v.x, floats, x.data() + lane);
    hn::Store(v.y, floats, y.data() + lane);
    hn::Store(v.z, floats, z.data() + lane);
  }
  [[nodiscard]] HWY_INLINE Vector load(std::size_t lane) const {
    return {hn::Load(floats, x.data() + lane), hn::Load(floats, y.data() + lane),
            hn::Load(floats, z.data() + lane)};
  }
};

/// Triangles for the test: the plane n x + offset, and the Pluecker coordinates of the sides.
struct Triangles {
  Stored normal;
  alignas(64) Lanes16 offset;
  std::array<Stored, 3> side;
  std::array<Stored, 3> moment;
};

HWY_INLINE void make_triangles(const ClusterBlock& block, std::size_t c, Triangles& triangles) {
  Corners corners;
  spread_out(block, c, corners);
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    const Cluster& cluster = *block.cluster[c];
    const Vector t[3] = {corner_of(corners, cluster, 0, lane), corner_of(corners, cluster, 1, lane),
                         corner_of(corners, cluster, 2, lane)};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector& next = t[(k + 1) % 3];
      triangles.side[k].store(difference(next, t[k]), lane);
      triangles.moment[k].store(cross(t[k], next), lane);
    }
    const Vector normal = cross(difference(t[1], t[0]), difference(t[2], t[0]));
    triangles.normal.store(normal, lane);
    hn::Store(hn::Neg(dot(normal, t[0])), floats, triangles.offset.data() + lane);
  }
}

/// An edge, copied to all lanes.
struct Edge {
  Vector a;
  Vector b;
  Vector along;
  Vector moment;
  HWY_INLINE Edge(const EdgeRows& edges, const FixedPoint& origin, std::int32_t e)
      : a(end(edges.a, origin, e)),
        b(end(edges.b, origin, e)),
        along(difference(b, a)),
        moment(cross(a, along)) {}

 private:
  static HWY_INLINE Vector end(const EdgeRows::End& end, const FixedPoint& origin, std::int32_t e) {
    const auto from = [](std::int32_t x, std::int32_t lower) {
      return hn::Set(floats, static_cast<float>(x - lower));
    };
    return {from(end.x[e], origin.x), from(end.y[e], origin.y), from(end.z[e], origin.z)};
  }
};

/// Six times the volume of an edge and a side.
HWY_INLINE Float volume(const Edge& edge, const Vector& side, const Vector& moment) {
  Float sum = hn::Mul(edge.along.x, moment.x);
  sum = hn::MulAdd(edge.along.y, moment.y, sum);
  sum = hn::MulAdd(edge.along.z, moment.z, sum);
  sum = hn::MulAdd(edge.moment.x, side.x, sum);
  sum = hn::MulAdd(edge.moment.y, side.y, sum);
  return hn::MulAdd(edge.moment.z, side.z, sum);
}
/// Six times the volume of a triangle and a point.
HWY_INLINE Float volume(const Vector& normal, Float offset, const Vector& p) {
  return hn::MulAdd(normal.x, p.x, hn::MulAdd(normal.y, p.y, hn::MulAdd(normal.z, p.z, offset)));
}

/// Bits of the triangles that the edge may meet; in the upper 16 bits, of those that it certainly meets.
HWY_INLINE std::uint32_t meets(const Triangles& triangles, std::size_t lane, const Edge& edge,
                               const CrossingBounds& bounds) {
  const Vector normal = triangles.normal.load(lane);
  const Float offset = hn::Load(floats, triangles.offset.data() + lane);
  const Float a = volume(normal, offset, edge.a);
  const Float b = volume(normal, offset, edge.b);
  const Float t0 = volume(edge, triangles.side[0].load(lane), triangles.moment[0].load(lane));
  const Float t1 = volume(edge, triangles.side[1].load(lane), triangles.moment[1].load(lane));
  const Float t2 = volume(edge, triangles.side[2].load(lane), triangles.moment[2].load(lane));
  const Float side = hn::Set(floats, bounds.side);
  const Float least = hn::Set(floats, bounds.volume);
  const Float low_side = hn::Min(a, b);
  const Float high_side = hn::Max(a, b);
  const Float low = hn::Min(t0, hn::Min(t1, t2));
  const Float high = hn::Max(t0, hn::Max(t1, t2));
  const auto beside = hn::Or(hn::Gt(low_side, side), hn::Lt(high_side, hn::Neg(side)));
  const auto around = hn::And(hn::Gt(high, least), hn::Lt(low, hn::Neg(least)));
  const auto through = hn::And(hn::Lt(low_side, hn::Neg(side)), hn::Gt(high_side, side));
  const auto within = hn::Or(hn::Gt(low, least), hn::Lt(high, hn::Neg(least)));
  const std::uint32_t may = bits_of(floats, hn::Not(hn::Or(beside, around)));
  return may | bits_of(floats, hn::And(through, within)) << 16;
}

void test_edges(const EdgeRows& edges, std::int32_t longest, ClusterBlock& block) {
  std::size_t hits = 0;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const std::uint32_t begin = block.first_candidate[c];
    const std::uint32_t end = block.first_candidate[c + 1];
    if (begin == end) continue;
    Triangles triangles;
    make_triangles(block, c, triangles);
    const ClusterBox& box = block.box[c];
    const CrossingBounds bounds = crossing_bounds(extent_of(box), static_cast<float>(longest));
    const std::uint32_t used = ((std::uint32_t{1} << block.cluster[c]->size) - 1) * 0x10001U;
    for (std::uint32_t i = begin; i < end; ++i) {
      const Edge edge(edges, box.lower, block.candidate[i]);
      std::uint32_t found = 0;
      for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes())
        found |= meets(triangles, lane, edge, bounds) << lane;
      found &= used;
      block.hit[hits] = {block.candidate[i], static_cast<std::uint32_t>(c), found};
      hits += found != 0 ? 1 : 0;
    }
  }
  block.hits = hits;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(filter_edges);
HWY_EXPORT(test_edges);

void filter_edges(const EdgeRows& edges, ClusterBlock& block) {
  HWY_DYNAMIC_DISPATCH(filter_edges)(edges, block);
}

void test_edges(const EdgeRows& edges, std::int32_t longest, ClusterBlock& block) {
  HWY_DYNAMIC_DISPATCH(test_edges)(edges, longest, block);
}

CrossingBounds crossing_bounds(float extent, float longest) {
  constexpr float u = 0x1p-24F;
  constexpr float slack = 1.001F;  // allows for the rounding of the bounds themselves
  const float reach = extent + longest;
  const float square = reach * reach;
  const float coordinate = 0.51F + u * reach;
  const float edge = 2.0F * coordinate + 1.01F * u * reach;
  const float normal = 4.0F * reach * edge + 2.0F * edge * edge + 4.1F * u * square;
  const float moment = 2.0F * reach * (edge + coordinate) + 2.0F * edge * coordinate + 4.1F * u * square;
  const float moments = 2.0F * moment;  // error of the edge's moment; that of the side's is not larger
  return {slack * (3.1F * normal * (2.0F * reach + 1.1F) + (12.1F * coordinate + 54.0F * u * reach) * square),
          slack * (3.1F * moments * (reach + edge) + (12.1F * edge + 54.0F * u * reach) * square)};
}

}  // namespace palpate::simd
#endif

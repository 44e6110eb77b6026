#include "simd/cluster_query.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/cluster_query.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>
// And ours, which is compiled with each target, after that.
#include "simd/cluster_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR
// A vector of one lane: the twins do as well.
void load(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
          ClusterBlock& block) {
  scalar::cluster_kernels().load(points, point_lists, block);
}
void filter(const PointRows& points, ClusterBlock& block) {
  scalar::cluster_kernels().filter(points, block);
}
void test(const PointRows& points, ClusterBlock& block) {
  scalar::cluster_kernels().test(points, block);
}
bool upright(const ClusterBlock& block) {
  return scalar::cluster_kernels().upright(block);
}
#else
namespace hn = hwy::HWY_NAMESPACE;

void load(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
          ClusterBlock& block) {
  const hn::FixedTag<std::int32_t, 4> d;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Cluster& cluster = *block.cluster[c];
    const std::int32_t* const list = point_lists.data() + cluster.first_point;
    auto lower = hn::Load(d, &points[static_cast<std::size_t>(list[0])].x);
    auto upper = lower;
    for (std::size_t i = 0; i < cluster.points; ++i) {
      const auto point = hn::Load(d, &points[static_cast<std::size_t>(list[i])].x);
      hn::Store(point, d, &block.corners[c][i].x);
      lower = hn::Min(lower, point);
      upper = hn::Max(upper, point);
    }
    hn::Store(lower, d, &block.box[c].lower.x);
    hn::Store(upper, d, &block.box[c].upper.x);
  }
}

void filter(const PointRows& points, ClusterBlock& block) {
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
    const Int own0 = hn::Set(ints, box.lower.name);
    const Int own1 = hn::Set(ints, box.upper.name);
    const Int skips_marked = hn::Set(ints, box.skips_marked);
    block.first_candidate[c] = static_cast<std::uint32_t>(count);
    for (std::uint32_t r = block.first_row[c]; r < block.first_row[c + 1]; ++r) {
      const PointRange row = block.rows[r];
      for (std::uint32_t e = row.begin; e < row.end; e += static_cast<std::uint32_t>(lanes())) {
        const Int x = hn::LoadU(ints, points.x + e);
        const Int y = hn::LoadU(ints, points.y + e);
        const Int z = hn::LoadU(ints, points.z + e);
        const Int name = hn::LoadU(ints, points.name + e);
        const Int place = hn::Add(first_places, hn::Set(ints, static_cast<std::int32_t>(e)));
        const Int beyond = hn::Sub(hn::Set(ints, static_cast<std::int32_t>(row.end - 1)), place);
        Int out = hn::Or(hn::Or(outside(x, x0, x1), outside(y, y0, y1)), outside(z, z0, z1));
        out = hn::Or(out, hn::Or(hn::And(name, skips_marked), beyond));
        const Int in = hn::AndNot(out, outside(name, own0, own1));
        const auto keep = hn::MaskFromVec(hn::BroadcastSignBit(in));
        count += store_kept(place, keep, block.candidate.data() + count);
      }
    }
  }
  block.first_candidate[block.clusters] = static_cast<std::uint32_t>(count);
}

/// Half spaces n x + c >= 0 of 16 tets, from the faces opposite their corners, and the bounds of their
/// errors.
struct Planes {
  alignas(64) std::array<std::array<std::array<float, Cluster::most_primitives>, 4>, 4> face;  ///< n, then c
  alignas(
      64) std::array<float, Cluster::most_primitives> bound;  ///< infinite where the tet's turn is not sure
};

HWY_INLINE void make_planes(const ClusterBlock& block, std::size_t c, Planes& planes) {
  Corners corners;
  spread_out(block, c, corners);
  const Float bound = hn::Set(floats, volume_bound(extent_of(block.box[c])));
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    const Cluster& cluster = *block.cluster[c];
    const Vector a = corner_of(corners, cluster, 0, lane);
    const Vector b = corner_of(corners, cluster, 1, lane);
    const Vector cc = corner_of(corners, cluster, 2, lane);
    const Vector d = corner_of(corners, cluster, 3, lane);
    const Vector da = difference(a, d);
    const Vector db = difference(b, d);
    const Vector dc = difference(cc, d);
    const Vector ab = difference(b, a);
    const Vector ac = difference(cc, a);
    // The signs that the predicates have: of the tet with one corner replaced.
    const Vector normal[4] = {cross(dc, db), cross(da, dc), cross(db, da), cross(ab, ac)};
    const Float volume = dot(normal[0], da);
    const auto sure = hn::Gt(hn::Abs(volume), bound);
    const Float infinite = hn::Set(floats, std::numeric_limits<float>::infinity());
    hn::Store(hn::IfThenElse(sure, bound, infinite), floats, planes.bound.data() + lane);
    const Float turn = hn::And(volume, hn::SignBit(floats));
    for (std::size_t face = 0; face < 4; ++face) {
      const Vector& n = normal[face];
      const Float offset = hn::Neg(dot(n, face < 3 ? d : a));
      hn::Store(hn::Xor(n.x, turn), floats, planes.face[face][0].data() + lane);
      hn::Store(hn::Xor(n.y, turn), floats, planes.face[face][1].data() + lane);
      hn::Store(hn::Xor(n.z, turn), floats, planes.face[face][2].data() + lane);
      hn::Store(hn::Xor(offset, turn), floats, planes.face[face][3].data() + lane);
    }
  }
}

struct Plane {
  Float x;
  Float y;
  Float z;
  Float offset;
  Plane(const Planes& planes, std::size_t face, std::size_t lane)
      : x(hn::Load(floats, planes.face[face][0].data() + lane)),
        y(hn::Load(floats, planes.face[face][1].data() + lane)),
        z(hn::Load(floats, planes.face[face][2].data() + lane)),
        offset(hn::Load(floats, planes.face[face][3].data() + lane)) {}
  [[nodiscard]] HWY_INLINE Float operator()(const Vector& p) const {
    return hn::MulAdd(x, p.x, hn::MulAdd(y, p.y, hn::MulAdd(z, p.z, offset)));
  }
};

/// Puts candidates of a cluster into the half spaces of the tets in the lanes from `lane` on.
class Test {
 public:
  Test(const PointRows& points, const FixedPoint& origin, const Planes& planes, std::size_t lane)
      : points_(points),
        x_(hn::Set(ints, origin.x)),
        y_(hn::Set(ints, origin.y)),
        z_(hn::Set(ints, origin.z)),
        a_(planes, 0, lane),
        b_(planes, 1, lane),
        c_(planes, 2, lane),
        d_(planes, 3, lane),
        bound_(hn::Load(floats, planes.bound.data() + lane)),
        no_less_(hn::Neg(bound_)) {}

  /// Bits of the tets that may contain a candidate, and << 16 of those that surely do.
  [[nodiscard]] HWY_INLINE std::uint32_t operator()(std::int32_t candidate) const {
    const Vector p{from(points_.x, candidate, x_), from(points_.y, candidate, y_),
                   from(points_.z, candidate, z_)};
    const Float least = hn::Min(hn::Min(a_(p), b_(p)), hn::Min(c_(p), d_(p)));
    const std::uint32_t may = bits_of(floats, hn::Ge(least, no_less_));
    return may | bits_of(floats, hn::Gt(least, bound_)) << 16;
  }

 private:
  static HWY_INLINE Float from(const std::int32_t* numbers, std::int32_t candidate, Int origin) {
    return hn::ConvertTo(floats, hn::Sub(hn::Set(ints, numbers[candidate]), origin));
  }
  const PointRows& points_;
  Int x_;
  Int y_;
  Int z_;
  Plane a_;
  Plane b_;
  Plane c_;
  Plane d_;
  Float bound_;
  Float no_less_;
};

void test(const PointRows& points, ClusterBlock& block) {
  std::array<std::uint32_t, ClusterBlock::most_points> tets;
  std::size_t hits = 0;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const std::uint32_t begin = block.first_candidate[c];
    const std::uint32_t end = block.first_candidate[c + 1];
    if (begin == end) continue;
    Planes planes;
    make_planes(block, c, planes);
    const auto take = [&](std::uint32_t i, std::uint32_t found) {
      block.hit[hits] = {block.candidate[i], static_cast<std::uint32_t>(c), found};
      hits += found != 0 ? 1 : 0;
    };
    const std::uint32_t used = ((std::uint32_t{1} << block.cluster[c]->size) - 1) * 0x10001U;
    // All lanes but the last ones leave their bits to those.
    constexpr std::size_t last = Cluster::most_primitives - lanes();
    for (std::size_t lane = 0; lane < last; lane += lanes()) {
      const Test test_lanes(points, block.box[c].lower, planes, lane);
      for (std::uint32_t i = begin; i < end; ++i) {
        const std::uint32_t found = test_lanes(block.candidate[i]) << lane;
        tets[i] = lane == 0 ? found : tets[i] | found;
      }
    }
    const Test test_last(points, block.box[c].lower, planes, last);
    for (std::uint32_t i = begin; i < end; ++i) {
      const std::uint32_t found = test_last(block.candidate[i]) << last;
      take(i, (last == 0 ? found : tets[i] | found) & used);
    }
  }
  block.hits = hits;
}

bool upright(const ClusterBlock& block) {
  auto all = hn::Eq(hn::Zero(floats), hn::Zero(floats));
  for (std::size_t c = 0; c < block.clusters; ++c) {
    Corners corners;
    spread_out(block, c, corners);
    const Cluster& cluster = *block.cluster[c];
    const Float bound = hn::Set(floats, volume_bound(extent_of(block.box[c])));
    // Lanes beyond the size hold the first tet.
    for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
      const Vector d = corner_of(corners, cluster, 3, lane);
      const Vector da = difference(corner_of(corners, cluster, 0, lane), d);
      const Vector db = difference(corner_of(corners, cluster, 1, lane), d);
      const Vector dc = difference(corner_of(corners, cluster, 2, lane), d);
      all = hn::And(all, hn::Gt(dot(cross(dc, db), da), bound));
    }
  }
  return hn::AllTrue(floats, all);
}
#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {
namespace {

HWY_EXPORT(load);
HWY_EXPORT(filter);
HWY_EXPORT(test);
HWY_EXPORT(upright);

}  // namespace

ClusterKernels cluster_kernels() {
  return {
      [](std::span<const FixedPoint> points, std::span<const std::int32_t> lists, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(load)(points, lists, block);
      },
      [](const PointRows& points, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(filter)
        (points, block);
      },
      [](const PointRows& points, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(test)
        (points, block);
      },
      [](const ClusterBlock& block) { return HWY_DYNAMIC_DISPATCH(upright)(block); },
  };
}

}  // namespace palpate::simd
#endif

#include "simd/cluster_query.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/cluster_query.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our header is compiled for each target, so it comes after that.
#include "simd/cluster_corners-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
#if HWY_TARGET == HWY_SCALAR
// On a target with one lane, use the kernels in plain C++.
void load(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
          ClusterBlock& block) {
  scalar::cluster_kernels().load(points, point_lists, block);
}
void filter(const PointRows& rows, ClusterBlock& block) {
  scalar::cluster_kernels().filter(rows, block);
}
void test(const FixedPoint* points, ClusterBlock& block) {
  scalar::cluster_kernels().test(points, block);
}
void near(const FixedPoint* points, std::int32_t margin, ClusterBlock& block) {
  scalar::cluster_kernels().near(points, margin, block);
}
void gather(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
            ClusterBlock& block) {
  scalar::cluster_kernels().gather(points, point_lists, block);
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

void gather(std::span<const FixedPoint> points, std::span<const std::int32_t> point_lists,
            ClusterBlock& block) {
  const hn::FixedTag<std::int32_t, 4> d;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Cluster& cluster = *block.cluster[c];
    const std::int32_t* const list = point_lists.data() + cluster.first_point;
    for (std::size_t i = 0; i < cluster.points; ++i)
      hn::Store(hn::Load(d, &points[static_cast<std::size_t>(list[i])].x), d, &block.corners[c][i].x);
  }
}

/// Tests one point per lane: whether its coarse word is in a box and its name is not excluded.
class BoxTest {
 public:
  BoxTest(const ClusterBox& box, int coarse_shift) {
    const FixedPoint& l = box.lower;
    const FixedPoint& u = box.upper;
    const auto lower = [&](std::int32_t number) {
      return Coarse::mask + 1 - (number >> coarse_shift & Coarse::mask);
    };
    const auto above = [&](std::int32_t from, std::int32_t to) {
      const std::int32_t extent = (to >> coarse_shift) - (from >> coarse_shift);
      largest_ = std::max(largest_, extent);
      return Coarse::mask - std::min(extent, Coarse::mask);
    };
    lower_ = Coarse::word(lower(l.x), lower(l.y), lower(l.z));
    above_ = Coarse::word(above(l.x, u.x), above(l.y, u.y), above(l.z, u.z));
    // If points of the own body count, exclude a name that no point has.
    first_name_ = includes_own(box) ? std::numeric_limits<std::int32_t>::max() : l.name;
    names_ = includes_own(box) ? 0 : u.name - l.name;
    marks_ = box.skips_marked & std::numeric_limits<std::int32_t>::min();
  }

  /// Whether the filter by coarse words passes only points in the box, among the points of the cells under
  /// it. Coarse numbers repeat, so with a larger box a point up to a cell outside could pass.
  [[nodiscard]] bool is_exact() const { return largest_ < Coarse::mask + 1 - 2 * (1 << Coarse::cell_bits); }

  [[nodiscard]] HWY_INLINE hn::Mask<Ints> operator()(const std::int32_t* words, Int name) const {
    constexpr std::int32_t all = Coarse::word(Coarse::mask, Coarse::mask, Coarse::mask);
    // Computes the distance above the lower end, and whether it exceeds the upper end. No carry reaches the
    // next axis.
    const Int from_lower =
        hn::And(hn::Add(hn::LoadU(ints, words), hn::Set(ints, lower_)), hn::Set(ints, all));
    const Int out = hn::AndNot(hn::Set(ints, all), hn::Add(from_lower, hn::Set(ints, above_)));
    const Int left_out = hn::And(name, hn::Set(ints, marks_));
    const hn::RebindToUnsigned<Ints> d;
    const auto own = hn::Sub(hn::BitCast(d, name), hn::Set(d, static_cast<std::uint32_t>(first_name_)));
    const auto other = hn::Gt(own, hn::Set(d, static_cast<std::uint32_t>(names_)));
    return hn::And(hn::Eq(hn::Or(out, left_out), hn::Zero(ints)), hn::RebindMask(ints, other));
  }

 private:
  std::int32_t lower_;
  std::int32_t above_;
  std::int32_t first_name_;
  std::int32_t names_;  ///< names of points, stored after their words
  std::int32_t marks_;
  std::int32_t largest_ = 0;
};

/// Keeps those candidates, from `first` on, that are in the box. Returns the new end of the list.
std::size_t keep_in_box(const FixedPoint* points, const ClusterBox& box, std::size_t first, std::size_t end,
                        std::int32_t* candidates) {
  std::size_t left = first;
  for (std::size_t i = first; i < end; ++i) {
    const FixedPoint& p = points[candidates[i]];
    const std::int32_t out = (p.x - box.lower.x) | (box.upper.x - p.x) | (p.y - box.lower.y) |
                             (box.upper.y - p.y) | (p.z - box.lower.z) | (box.upper.z - p.z);
    candidates[left] = candidates[i];
    left += out >= 0 ? 1 : 0;
  }
  return left;
}

void filter(const PointRows& rows, ClusterBlock& block) {
  std::size_t count = 0;
  block.candidates = block.candidate.data();
  std::int32_t* const candidates = block.candidate.data();
  const Int unmarked = hn::Set(ints, index_of_name(-1));
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const BoxTest in_box(block.box[c], rows.coarse_shift);
    const std::size_t first = count;
    block.first_candidate[c] = static_cast<std::uint32_t>(first);
    for (std::uint32_t r = block.first_row[c]; r < block.first_row[c + 1]; ++r) {
      const PointRange row = block.rows[r];
      for (std::uint32_t e = row.begin; e < row.end; e += static_cast<std::uint32_t>(lanes())) {
        const Int name = hn::LoadU(ints, rows.names + e);
        const auto keep = hn::And(in_box(rows.words + e, name), hn::FirstN(ints, row.end - e));
        count += store_kept(hn::And(name, unmarked), keep, candidates + count);
      }
    }
    if ((block.strays >> c & 1U) != 0 || !in_box.is_exact())
      count = keep_in_box(rows.points, block.box[c], first, count, candidates);
  }
  block.first_candidate[block.clusters] = static_cast<std::uint32_t>(count);
}

/// Half spaces n x + c >= 0 of 16 tets, one for the face opposite each corner, and their error bounds.
struct Planes {
  alignas(64) std::array<std::array<std::array<float, Cluster::most_primitives>, 4>,
                         4> face;                                 ///< n in rows 0 to 2, then c
  alignas(64) std::array<float, Cluster::most_primitives> bound;  ///< infinite where the sign of the tet's
};

/// By how much planes are moved outwards, and the error bound of the moved planes.
struct Widening {
  float reach;  ///< for a unit 1-norm of the normal
  float bound;
};

template <bool is_wide>
HWY_INLINE void make_planes(const ClusterBlock& block, std::size_t c, const Corners& corners,
                            const Widening& widening, Planes& planes) {
  const Float bound = hn::Set(floats, widening.bound);
  for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
    const Cluster& cluster = *block.cluster[c];
    const Vector a = corners.of(cluster, 0, lane);
    const Vector b = corners.of(cluster, 1, lane);
    const Vector cc = corners.of(cluster, 2, lane);
    const Vector d = corners.of(cluster, 3, lane);
    const Vector da = difference(a, d);
    const Vector db = difference(b, d);
    const Vector dc = difference(cc, d);
    const Vector ab = difference(b, a);
    const Vector ac = difference(cc, a);
    // Signs are as in the predicates: of the volume of the tet with one corner replaced.
    const Vector normal[4] = {cross(dc, db), cross(da, dc), cross(db, da), cross(ab, ac)};
    const Float volume = dot(normal[0], da);
    const auto sure = hn::Gt(hn::Abs(volume), bound);
    const Float infinite = hn::Set(floats, std::numeric_limits<float>::infinity());
    hn::Store(hn::IfThenElse(sure, bound, infinite), floats, planes.bound.data() + lane);
    const Float flip = hn::And(volume, hn::SignBit(floats));
    for (std::size_t face = 0; face < 4; ++face) {
      const Vector& n = normal[face];
      Float offset = hn::Neg(dot(n, face < 3 ? d : a));
      if constexpr (is_wide) {
        const Float size = hn::Add(hn::Add(hn::Abs(n.x), hn::Abs(n.y)), hn::Abs(n.z));
        const Float further = hn::Mul(hn::Set(floats, widening.reach), size);
        offset = hn::Add(offset, hn::Xor(further, flip));  // flipped again below
      }
      hn::Store(hn::Xor(n.x, flip), floats, planes.face[face][0].data() + lane);
      hn::Store(hn::Xor(n.y, flip), floats, planes.face[face][1].data() + lane);
      hn::Store(hn::Xor(n.z, flip), floats, planes.face[face][2].data() + lane);
      hn::Store(hn::Xor(offset, flip), floats, planes.face[face][3].data() + lane);
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

/// Evaluates candidates of a cluster in the half spaces of the tets in the lanes from `lane` on.
class Test {
 public:
  Test(const FixedPoint* points, const FixedPoint& origin, const Planes& planes, std::size_t lane)
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

  /// Bits of the tets that may contain a candidate; in the upper 16 bits, of the tets that certainly do.
  [[nodiscard]] HWY_INLINE std::uint32_t operator()(std::int32_t candidate) const {
    const FixedPoint& point = points_[candidate];
    const Float least = least_of({from(point.x, x_), from(point.y, y_), from(point.z, z_)});
    return may(least) | bits_of(floats, hn::Gt(least, bound_)) << 16;
  }
  /// These bits for a corner of the cluster.
  [[nodiscard]] HWY_INLINE std::uint32_t of_corner(const Corners& corners, std::size_t i) const {
    const Float least = least_of(corners.point(i));
    return may(least) | bits_of(floats, hn::Gt(least, bound_)) << 16;
  }

 private:
  [[nodiscard]] HWY_INLINE Float least_of(const Vector& p) const {
    return hn::Min(hn::Min(a_(p), b_(p)), hn::Min(c_(p), d_(p)));
  }
  [[nodiscard]] HWY_INLINE std::uint32_t may(Float least) const {
    return bits_of(floats, hn::Ge(least, no_less_));
  }
  static HWY_INLINE Float from(std::int32_t number, Int origin) {
    return hn::ConvertTo(floats, hn::Sub(hn::Set(ints, number), origin));
  }
  const FixedPoint* points_;
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

/// The candidates of a cluster in two groups: its own points, and all others.
struct Sorted {
  std::size_t others = 0;
  std::array<std::int32_t, ClusterBlock::most_points + 1> other;
  std::array<std::int32_t, Cluster::most_points + 1>
      own;  ///< by index in the cluster's list; -1: not a candidate
};

HWY_INLINE void sort_candidates(const FixedPoint* points, std::span<const FixedPoint> corners,
                                std::span<const std::int32_t> candidates, Sorted& sorted) {
  alignas(64) std::array<std::int32_t, Cluster::most_points> names;
  const std::size_t vectors = (corners.size() + lanes() - 1) / lanes();
  for (std::size_t i = 0; i < vectors * lanes(); ++i) {
    names[i] = i < corners.size() ? corners[i].name : 0;
    sorted.own[i] = -1;
  }
  std::size_t others = 0;
  const auto used = static_cast<std::uint32_t>((std::uint64_t{1} << corners.size()) - 1);
  for (const std::int32_t candidate : candidates) {
    const Int name = hn::Set(ints, points[candidate].name);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < vectors * lanes(); i += lanes())
      bits |= bits_of(ints, hn::Eq(hn::Load(ints, names.data() + i), name)) << i;
    bits &= used;
    // A point is in the list at most once. If it is not in the list, it is written to the last place, which
    // is unused.
    const std::uint64_t place = bits | std::uint64_t{1} << Cluster::most_points;
    sorted.own[static_cast<std::size_t>(std::countr_zero(place))] = candidate;
    sorted.other[others] = candidate;
    others += bits == 0 ? 1 : 0;
  }
  sorted.others = others;
}

template <bool is_wide>
HWY_INLINE void test_block(const FixedPoint* points, std::int32_t margin, ClusterBlock& block) {
  std::array<std::uint32_t, ClusterBlock::most_points> tets;
  Sorted sorted;
  std::size_t hits = 0;
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Cluster& cluster = *block.cluster[c];
    std::span<const std::int32_t> candidates(block.candidates + block.first_candidate[c],
                                             block.first_candidate[c + 1] - block.first_candidate[c]);
    if (candidates.empty()) continue;
    const Corners corners(block, c);
    Planes planes;
    const float extent = extent_of(block.box[c]);
    make_planes<is_wide>(block, c, corners,
                         {reach_of(margin), is_wide ? near_bound(extent, margin) : volume_bound(extent)},
                         planes);
    const bool has_own = includes_own(block.box[c]);
    if (has_own) {
      sort_candidates(points, std::span(block.corners[c]).first(cluster.points), candidates, sorted);
      candidates = std::span(sorted.other).first(sorted.others);
    }
    const auto take = [&](std::int32_t entry, std::uint32_t found) {
      block.hit[hits] = {entry, static_cast<std::uint32_t>(c), found};
      hits += found != 0 ? 1 : 0;
    };
    const std::uint32_t used = ((std::uint32_t{1} << cluster.size) - 1) * 0x10001U;
    std::array<std::uint32_t, Cluster::most_points> of_corner;
    // The last vector of lanes writes the bits of all vectors.
    constexpr std::size_t last = Cluster::most_primitives - lanes();
    for (std::size_t lane = 0; lane < last; lane += lanes()) {
      const Test test_lanes(points, block.box[c].lower, planes, lane);
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        const std::uint32_t found = test_lanes(candidates[i]) << lane;
        tets[i] = lane == 0 ? found : tets[i] | found;
      }
      for (std::size_t i = 0; has_own && i < cluster.points; ++i) {
        const std::uint32_t found = test_lanes.of_corner(corners, i) << lane;
        of_corner[i] = lane == 0 ? found : of_corner[i] | found;
      }
    }
    const Test test_last(points, block.box[c].lower, planes, last);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const std::uint32_t found = test_last(candidates[i]) << last;
      take(candidates[i], (last == 0 ? found : tets[i] | found) & used);
    }
    for (std::size_t i = 0; has_own && i < cluster.points; ++i) {
      const std::uint32_t at_last = test_last.of_corner(corners, i) << last;
      const std::uint32_t found = (last == 0 ? at_last : of_corner[i] | at_last) & used;
      const std::uint32_t at_point = block.at_point[static_cast<std::size_t>(cluster.first_point) + i];
      const std::uint32_t left = found & ~(at_point * 0x10001U);
      if (left != 0 && sorted.own[i] >= 0) take(sorted.own[i], left);
    }
  }
  block.hits = hits;
}

void test(const FixedPoint* points, ClusterBlock& block) {
  test_block<false>(points, 0, block);
}
void near(const FixedPoint* points, std::int32_t margin, ClusterBlock& block) {
  test_block<true>(points, margin, block);
}

bool upright(const ClusterBlock& block) {
  auto all = hn::Eq(hn::Zero(floats), hn::Zero(floats));
  for (std::size_t c = 0; c < block.clusters; ++c) {
    const Corners corners(block, c);
    const Cluster& cluster = *block.cluster[c];
    const Float bound = hn::Set(floats, volume_bound(extent_of(block.box[c])));
    // Lanes beyond the size hold a copy of the first tet.
    for (std::size_t lane = 0; lane < Cluster::most_primitives; lane += lanes()) {
      const Vector d = corners.of(cluster, 3, lane);
      const Vector da = difference(corners.of(cluster, 0, lane), d);
      const Vector db = difference(corners.of(cluster, 1, lane), d);
      const Vector dc = difference(corners.of(cluster, 2, lane), d);
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
HWY_EXPORT(near);
HWY_EXPORT(gather);
HWY_EXPORT(upright);

}  // namespace

ClusterKernels cluster_kernels() {
  return {
      [](std::span<const FixedPoint> points, std::span<const std::int32_t> lists, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(load)(points, lists, block);
      },
      [](const PointRows& rows, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(filter)
        (rows, block);
      },
      [](const FixedPoint* points, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(test)
        (points, block);
      },
      [](const FixedPoint* points, std::int32_t margin, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(near)(points, margin, block);
      },
      [](std::span<const FixedPoint> points, std::span<const std::int32_t> lists, ClusterBlock& block) {
        HWY_DYNAMIC_DISPATCH(gather)(points, lists, block);
      },
      [](const ClusterBlock& block) { return HWY_DYNAMIC_DISPATCH(upright)(block); },
  };
}

}  // namespace palpate::simd
#endif

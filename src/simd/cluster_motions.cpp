#include "simd/cluster_motions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/cluster_motions.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>
// Our headers are compiled for each target, so they come after that.
#include "simd/cluster_lanes-inl.hpp"
#include "simd/point_lanes-inl.hpp"
#include "simd/row_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {

struct Range {
  Coordinates lower;
  Coordinates upper;
};
HWY_INLINE Range nothing() {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  return {hn::Set(coordinates, infinity), hn::Set(coordinates, -infinity)};
}
HWY_INLINE void extend(Range& range, Coordinates x) {
  range.lower = hn::Min(range.lower, x);
  range.upper = hn::Max(range.upper, x);
}
HWY_INLINE void store_coordinates(Coordinates x, double* to, std::size_t part) {
  if constexpr (parts == 1) {
    hn::BlendedStore(x, hn::FirstN(coordinates, 3), coordinates, to);
  } else {
    hn::StoreU(x, coordinates, to + part);
  }
}
HWY_INLINE void store(const Range& range, PlaceBox& box, std::size_t part) {
  store_coordinates(range.lower, &box.lower.x, part);
  store_coordinates(range.upper, &box.upper.x, part);
}
HWY_INLINE void extend(Range& range, const Range& other) {
  range.lower = hn::Min(range.lower, other.lower);
  range.upper = hn::Max(range.upper, other.upper);
}
HWY_INLINE Coordinates largest_of(const Range& range) {
  return hn::Max(hn::Abs(range.lower), hn::Abs(range.upper));
}

/// The box in float, grown by an error.
HWY_INLINE void store(const Range& range, Coordinates error, DisplacementBox& box, std::size_t part) {
  constexpr double rounding = 1.0 + 1e-6;
  constexpr double smallest = std::numeric_limits<float>::min();
  const hn::Rebind<float, CoordinateTag> in_float;
  const auto middle =
      hn::DemoteTo(in_float, hn::Mul(hn::Set(coordinates, 0.5), hn::Add(range.lower, range.upper)));
  const Coordinates from = hn::PromoteTo(coordinates, middle);
  const Coordinates half = hn::Add(hn::Max(hn::Sub(range.upper, from), hn::Sub(from, range.lower)), error);
  const Coordinates grown =
      hn::Max(hn::Mul(half, hn::Set(coordinates, rounding)), hn::Set(coordinates, smallest));
  const Coordinates zero = hn::Zero(coordinates);
  hn::StoreU(middle, in_float, box.middle.data() + part);
  hn::StoreU(hn::DemoteTo(in_float, hn::IfThenZeroElse(hn::Eq(half, zero), grown)), in_float,
             box.half.data() + part);
}

struct Followed {
  Range places;
  Range displacements;
  Range remainders;
};
HWY_INLINE Followed no_points() {
  return {nothing(), nothing(), nothing()};
}

template <bool has_remainders>
HWY_INLINE Followed follow_points(const Vec3* now, const Vec3* before, std::span<const Index> points,
                                  const LinearMotion* common, std::size_t part) {
  const auto column = [&](std::size_t k)
                          HWY_ATTR { return hn::LoadU(coordinates, (*common)[k].data() + part); };
  Followed followed = no_points();
  for (const Index p : points) {
    const Vec3& from = before[p];
    const Coordinates to = load(now[p], part);
    const Coordinates displacement = hn::Sub(to, load(from, part));
    extend(followed.places, to);
    extend(followed.displacements, displacement);
    if constexpr (has_remainders) {
      Coordinates moved = hn::MulAdd(hn::Set(coordinates, from.x), column(0), column(3));
      moved = hn::MulAdd(hn::Set(coordinates, from.y), column(1), moved);
      moved = hn::MulAdd(hn::Set(coordinates, from.z), column(2), moved);
      extend(followed.remainders, hn::Sub(displacement, moved));
    }
  }
  return followed;
}

template <bool has_remainders>
HWY_INLINE FollowedPoints follow_clusters(const Vec3* now, const Vec3* before, const Index* points,
                                          std::span<const Cluster> clusters, const LinearMotion* common,
                                          double error, const FollowedClusters& to) {
  constexpr double of_displacement = 4e-16;
  constexpr double of_remainder = 1e-15;
  FollowedPoints result;
  for (std::size_t part = 0; part < parts; ++part) {
    Followed all = no_points();
    Coordinates sides = hn::Zero(coordinates);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      const Followed here = follow_points<has_remainders>(
          now, before, {points + clusters[c].first_point, clusters[c].points}, common, part);
      store_coordinates(here.places.lower, to.places + 6 * c, part);
      store_coordinates(here.places.upper, to.places + 6 * c + 3, part);
      const Coordinates displaced = largest_of(here.displacements);
      store(here.displacements, hn::Mul(displaced, hn::Set(coordinates, of_displacement)),
            to.displacements[c], part);
      extend(all.places, here.places);
      extend(all.displacements, here.displacements);
      sides = hn::Max(sides, hn::Sub(here.places.upper, here.places.lower));
      if constexpr (has_remainders) {
        store(here.remainders,
              hn::MulAdd(displaced, hn::Set(coordinates, of_remainder), hn::Set(coordinates, error)),
              to.remainders[c], part);
        extend(all.remainders, here.remainders);
      }
    }
    store(all.places, result.places, part);
    store(all.displacements, result.displacements, part);
    if constexpr (has_remainders) store(all.remainders, result.remainders, part);
    store_coordinates(sides, &result.sides.x, part);
  }
  return result;
}

/// The largest distance of two displacements of two boxes, along each axis.
HWY_INLINE void put_furthest(const DisplacementBox& a, const DisplacementBox& b, float* to) {
#if HWY_TARGET == HWY_SCALAR
  for (std::size_t k = 0; k < 3; ++k) to[k] = std::abs(a.middle[k] - b.middle[k]) + (a.half[k] + b.half[k]);
#else
  const hn::FixedTag<float, 4> row;
  const auto load = [&](const std::array<float, 4>& from) HWY_ATTR { return hn::Load(row, from.data()); };
  const auto middle = hn::Sub(load(a.middle), load(b.middle));
  hn::Store(hn::Add(hn::Abs(middle), hn::Add(load(a.half), load(b.half))), row, to);
#endif
}
/// The largest distance of two displacements of the boxes of each pair.
HWY_INLINE Float furthest(const DisplacementBox* motions, const Index* first, const Index* second,
                          std::size_t size) {
  alignas(64) std::array<float, 4> rows[lanes()];
  for (std::size_t i = 0; i < size; ++i) put_furthest(motions[first[i]], motions[second[i]], rows[i].data());
  for (std::size_t i = size; i < lanes(); ++i) rows[i] = {};
  const auto [x, y, z] = load_rows(floats, [&](std::size_t lane) HWY_ATTR { return rows[lane].data(); });
  const Float square = hn::MulAdd(x, x, hn::MulAdd(y, y, hn::Mul(z, z)));
  constexpr float smallest = 1e-30F;  // square with full precision
  const Float distance =
      hn::IfThenElse(hn::Lt(square, hn::Set(floats, smallest)), hn::Add(x, hn::Add(y, z)), hn::Sqrt(square));
  constexpr float rounding = 1.0F + 1e-6F;
  return hn::Mul(distance, hn::Set(floats, rounding));
}

}  // namespace

FollowedPoints follow(const Vec3* now, const Vec3* before, const Index* points,
                      std::span<const Cluster> clusters, const LinearMotion* common, double error,
                      const FollowedClusters& followed) {
  if (common == nullptr)
    return follow_clusters<false>(now, before, points, clusters, common, error, followed);
  return follow_clusters<true>(now, before, points, clusters, common, error, followed);
}

std::size_t move_pairs(const DisplacementBox* motions, const MovingPairs& pairs, std::size_t begin,
                       std::size_t end, std::int32_t* due) {
  std::size_t size = 0;
  for (std::size_t i = begin; i < end; i += lanes()) {
    const std::size_t here = std::min(lanes(), end - i);
    const auto ours = hn::FirstN(floats, here);
    const auto read = [&](const float* column) HWY_ATTR { return load_some(floats, column + i, here); };
    const Float by = furthest(motions, pairs.first + i, pairs.second + i, here);
    const Float usual = hn::Max(by, hn::Mul(hn::Set(floats, 0.5F), read(pairs.usual)));
    const Float before = read(pairs.moved);
    constexpr float rounding = 1.0F + 2.4e-7F;
    // Not rounded upwards again and again where nothing moves.
    const Float moved = hn::IfThenElse(hn::Eq(by, hn::Zero(floats)), before,
                                       hn::Mul(hn::Add(before, by), hn::Set(floats, rounding)));
    store_some(usual, floats, pairs.usual + i, here);
    store_some(moved, floats, pairs.moved + i, here);
    // What is not a number is due.
    const auto stays = hn::And(hn::Le(moved, read(pairs.room)), hn::Lt(moved, read(pairs.apart)));
    const auto keep = hn::RebindMask(ints, hn::And(ours, hn::Not(stays)));
    if (hn::AllFalse(ints, keep)) continue;
    const Int numbers = hn::Add(hn::Iota(ints, 0), hn::Set(ints, static_cast<std::int32_t>(i)));
    size += store_kept(numbers, keep, due + size);
  }
  return size;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(follow);
HWY_EXPORT(move_pairs);

FollowedPoints follow(const Vec3* now, const Vec3* before, const Index* points,
                      std::span<const Cluster> clusters, const LinearMotion* common, double error,
                      const FollowedClusters& followed) {
  return HWY_DYNAMIC_DISPATCH(follow)(now, before, points, clusters, common, error, followed);
}
std::size_t move_pairs(const DisplacementBox* motions, const MovingPairs& pairs, std::size_t begin,
                       std::size_t end, std::int32_t* due) {
  return HWY_DYNAMIC_DISPATCH(move_pairs)(motions, pairs, begin, end, due);
}

}  // namespace palpate::simd
#endif

// The corners of a cluster's primitives in lanes. Included once for each target.
#if defined(PALPATE_SIMD_CLUSTER_CORNERS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_CLUSTER_CORNERS_INL
#undef PALPATE_SIMD_CLUSTER_CORNERS_INL
#else
#define PALPATE_SIMD_CLUSTER_CORNERS_INL
#endif

#include <array>
#include <cstddef>
#include <cstdint>
#include <hwy/highway.h>

#include "simd/cluster_lanes-inl.hpp"
#include "simd/row_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
#if HWY_TARGET != HWY_SCALAR
namespace {

/// The points of a cluster, relative to the lower corner of its box.
class Corners {
 public:
#if HWY_MAX_BYTES >= 64
  // Numbers are looked up in registers, so they are stored in columns.
  HWY_INLINE Corners(const ClusterBlock& block, std::size_t c) {
    const FixedPoint& lower = block.box[c].lower;
    for (std::size_t i = 0; i < block.cluster[c]->points; i += lanes()) {
      Int x;
      Int y;
      Int z;
      Int name;
      hn::LoadInterleaved4(ints, &block.corners[c][i].x, x, y, z, name);
      hn::Store(hn::ConvertTo(floats, hn::Sub(x, hn::Set(ints, lower.x))), floats, x_.data() + i);
      hn::Store(hn::ConvertTo(floats, hn::Sub(y, hn::Set(ints, lower.y))), floats, y_.data() + i);
      hn::Store(hn::ConvertTo(floats, hn::Sub(z, hn::Set(ints, lower.z))), floats, z_.data() + i);
    }
  }
  /// A corner of the primitives in the lanes from `lane` on.
  [[nodiscard]] HWY_INLINE Vector of(const Cluster& cluster, std::size_t corner, std::size_t lane) const {
    const hn::Rebind<std::uint8_t, Ints> bytes;
    const Int places = hn::PromoteTo(ints, hn::LoadU(bytes, cluster.corners[corner].data() + lane));
    const auto half = hn::IndicesFromVec(floats, hn::And(places, hn::Set(ints, 15)));
    const auto is_upper = hn::RebindMask(floats, hn::Gt(places, hn::Set(ints, 15)));
    const auto pick = [&](const Column& from) HWY_ATTR {
      return hn::IfThenElse(is_upper, hn::TableLookupLanes(hn::Load(floats, from.data() + 16), half),
                            hn::TableLookupLanes(hn::Load(floats, from.data()), half));
    };
    return {pick(x_), pick(y_), pick(z_)};
  }
  /// A point, in all lanes.
  [[nodiscard]] HWY_INLINE Vector point(std::size_t i) const {
    return {hn::Set(floats, x_[i]), hn::Set(floats, y_[i]), hn::Set(floats, z_[i])};
  }

 private:
  using Column = std::array<float, Cluster::most_points>;
  alignas(64) Column x_;
  alignas(64) Column y_;
  alignas(64) Column z_;
#else
  HWY_INLINE Corners(const ClusterBlock& block, std::size_t c) {
    const hn::FixedTag<std::int32_t, 4> row;
    const hn::FixedTag<float, 4> in_float;
    const auto lower = hn::LoadU(row, &block.box[c].lower.x);
    for (std::size_t i = 0; i < block.cluster[c]->points; ++i) {
      const auto local = hn::Sub(hn::Load(row, &block.corners[c][i].x), lower);
      hn::Store(hn::ConvertTo(in_float, local), in_float, rows_[i].data());
    }
  }
  /// A corner of the primitives in the lanes from `lane` on.
  [[nodiscard]] HWY_INLINE Vector of(const Cluster& cluster, std::size_t corner, std::size_t lane) const {
    const std::uint8_t* const places = cluster.corners[corner].data() + lane;
    const auto [x, y, z] =
        load_rows(floats, [&](std::size_t at) HWY_ATTR { return rows_[places[at]].data(); });
    return {x, y, z};
  }
  /// A point, in all lanes.
  [[nodiscard]] HWY_INLINE Vector point(std::size_t i) const {
    return {hn::Set(floats, rows_[i][0]), hn::Set(floats, rows_[i][1]), hn::Set(floats, rows_[i][2])};
  }

 private:
  alignas(64) std::array<std::array<float, 4>, Cluster::most_points> rows_;
#endif
};

}  // namespace
#endif
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// Rows of four numbers from scattered places to lanes. Many processors load rows and transpose them in less
// time than they gather single numbers. Included once for each target.
#if defined(PALPATE_SIMD_ROW_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef PALPATE_SIMD_ROW_LANES_INL
#undef PALPATE_SIMD_ROW_LANES_INL
#else
#define PALPATE_SIMD_ROW_LANES_INL
#endif

#include <cstddef>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

/// The first three numbers of rows, one row per lane.
template <class D>
struct RowColumns {
  hn::Vec<D> x;
  hn::Vec<D> y;
  hn::Vec<D> z;
};

#if HWY_TARGET != HWY_SCALAR
/// The 16 bytes of the lanes from, from + n, and so on, where 16 bytes have n numbers.
template <class D, class Place>
HWY_INLINE hn::Vec<D> every_nth(D d, const Place& place, std::size_t from) {
  if constexpr (hn::MaxLanes(D()) * sizeof(hn::TFromD<D>) == 16) {
    return hn::LoadU(d, place(from));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, every_nth(half, place, from + hn::MaxLanes(half)), every_nth(half, place, from));
  }
}
#endif

/// The rows at place(lane), a pointer to four numbers of 4 bytes. It is called just before the load.
template <class D, class Place>
HWY_INLINE RowColumns<D> load_rows(D d, const Place& place) {
#if HWY_TARGET == HWY_SCALAR
  return {hn::LoadU(d, place(0)), hn::LoadU(d, place(0) + 1), hn::LoadU(d, place(0) + 2)};
#else
  const hn::Repartition<double, D> pairs;
  const auto row0 = every_nth(d, place, 0);
  const auto row1 = every_nth(d, place, 1);
  const auto row2 = every_nth(d, place, 2);
  const auto row3 = every_nth(d, place, 3);
  const auto xy01 = hn::BitCast(pairs, hn::InterleaveLower(d, row0, row1));
  const auto xy23 = hn::BitCast(pairs, hn::InterleaveLower(d, row2, row3));
  const auto zw01 = hn::BitCast(pairs, hn::InterleaveUpper(d, row0, row1));
  const auto zw23 = hn::BitCast(pairs, hn::InterleaveUpper(d, row2, row3));
  return {hn::BitCast(d, hn::InterleaveLower(pairs, xy01, xy23)),
          hn::BitCast(d, hn::InterleaveUpper(pairs, xy01, xy23)),
          hn::BitCast(d, hn::InterleaveLower(pairs, zw01, zw23))};
#endif
}

}  // namespace
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

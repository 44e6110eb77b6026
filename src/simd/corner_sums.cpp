#include "simd/corner_sums.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/corner_sums.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void add_corners(const double* values, const std::uint16_t* places, std::size_t elements, Padded3* sums) {
  const hn::CappedTag<double, 4> d;
  constexpr std::size_t stride = 16;
  for (std::size_t first = 0; first < stride; ++first) {
    for (std::size_t e = first; e < elements; e += stride) {
      for (std::size_t c = 4 * e; c < 4 * e + 4; ++c) {
        double* sum = &sums[places[c]].x;
        for (std::size_t k = 0; k < 4; k += hn::Lanes(d))
          hn::StoreU(hn::Add(hn::LoadU(d, sum + k), hn::LoadU(d, values + 4 * c + k)), d, sum + k);
      }
    }
  }
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(add_corners);

void add_corners(const double* values, const std::uint16_t* places, std::size_t elements, Padded3* sums) {
  HWY_DYNAMIC_DISPATCH(add_corners)(values, places, elements, sums);
}

}  // namespace palpate::simd
#endif

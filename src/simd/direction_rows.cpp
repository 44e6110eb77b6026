#include "simd/direction_rows.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/direction_rows.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
#include "simd/direction_rows-inl.hpp"
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {
namespace scalar {
namespace plain {
#include "simd/direction_rows-inl.hpp"  // NOLINT(readability-duplicate-include): once a target
}  // namespace plain

double dot_floats(const float* a, const float* b, std::size_t n) {
  return plain::dot_floats(a, b, n);
}
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n) {
  return plain::dot_two(a, b, c, n);
}
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n) {
  plain::subtract_combination(vectors, s, a, n);
}
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n) {
  plain::combine_in_double(vectors, s, a, n);
}
}  // namespace scalar

HWY_EXPORT(dot_floats);
HWY_EXPORT(dot_two);
HWY_EXPORT(subtract_combination);
HWY_EXPORT(combine_in_double);

double dot_floats(const float* a, const float* b, std::size_t n) {
  return HWY_DYNAMIC_DISPATCH(dot_floats)(a, b, n);
}
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n) {
  return HWY_DYNAMIC_DISPATCH(dot_two)(a, b, c, n);
}
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n) {
  HWY_DYNAMIC_DISPATCH(subtract_combination)(vectors, s, a, n);
}
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n) {
  HWY_DYNAMIC_DISPATCH(combine_in_double)(vectors, s, a, n);
}

}  // namespace palpate::simd
#endif

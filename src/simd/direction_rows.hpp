#pragma once

#include <cstddef>

#include "simd/sliced_rows.hpp"

/// Kernels on long vectors for a solver in the span of a few directions. Sums have fixed lanes: the same bits
/// on every target.
namespace palpate::simd {

/// Sum of a b; n is a multiple of slice_values. Sums within a slice are in float, sums of slices in double.
double dot_floats(const float* a, const float* b, std::size_t n);
/// `first`: a b, `second`: a c.
struct TwoSums {
  double first;
  double second;
};
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n);

/// A list of vectors, `stride` numbers apart.
struct FloatVectors {
  const float* values;
  std::size_t stride;
  std::size_t count;
};
/// a -= sum_i s_i v_i, of n numbers.
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n);
/// a = sum_i s_i v_i, of n numbers.
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n);

/// The kernels above for the simplest target.
namespace scalar {
double dot_floats(const float* a, const float* b, std::size_t n);
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n);
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n);
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n);
}  // namespace scalar

}  // namespace palpate::simd

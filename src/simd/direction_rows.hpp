#pragma once

#include <cstddef>

#include <palpate/types.hpp>

#include "simd/sliced_rows.hpp"

/// What a solver in the span of a few directions does with long vectors, and with what the directions change
/// of each contact. Sums have fixed lanes: the same bits on every target.
namespace palpate::simd {

/// Directions go in groups of so many; rows are padded to them, with finite numbers.
inline constexpr std::size_t direction_lanes = 8;

/// Sums of a b; n is a multiple of slice_values. Slice by slice in float, by slice_rows lanes in double.
double dot_floats(const float* a, const float* b, std::size_t n);
/// `first`: a b, `second`: a c.
struct TwoSums {
  double first;
  double second;
};
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n);

/// Vectors of a list: one every `stride` numbers.
struct FloatVectors {
  const float* values;
  std::size_t stride;
  std::size_t count;
};
/// a -= sum_i s_i v_i, of n numbers.
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n);
/// a = sum_i s_i v_i, of n numbers.
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n);

/// J of contacts: three rows of `stride` numbers for each, of which the first n, padded, count.
struct ContactRates {
  const double* values;
  std::size_t stride;
  std::size_t n;
};
/// u_k = J_k c of contacts [begin, end).
void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end);
/// sum += J_k^T f_k (n, padded).
void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end);
/// sum += J_k^T H_k J_k (n rows of `stride`); zero H are passed over.
/// \param h  nine numbers a contact, row by row
void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end);
/// Row and column of direction i of the same: row_l += (J^T H J)_il, column_l += (J^T H J)_li (n, padded).
void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end);

/// The same for the plainest target.
namespace scalar {
double dot_floats(const float* a, const float* b, std::size_t n);
TwoSums dot_two(const float* a, const float* b, const float* c, std::size_t n);
void subtract_combination(const FloatVectors& vectors, const float* s, float* a, std::size_t n);
void combine_in_double(const FloatVectors& vectors, const double* s, double* a, std::size_t n);
void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end);
void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end);
void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end);
void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd

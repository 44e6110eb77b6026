#pragma once

#include <cstddef>

#include <palpate/types.hpp>

/// Kernels for contact velocities in the span of a few directions. Sums have a fixed order and fixed lanes,
/// so the bits are the same on every target.
namespace palpate::simd {

/// Directions per group. Rows are padded to whole groups with finite numbers.
inline constexpr std::size_t direction_lanes = 8;

/// J of contacts: for each contact three rows of `stride` numbers, of which the first n (padded) are used. In
/// float, as the directions are; sums are in double.
struct ContactRates {
  const float* values;
  std::size_t stride;
  std::size_t n;
};
/// u_k = J_k c of contacts [begin, end).
void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end);
/// sum += J_k^T f_k (n, padded).
void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end);
/// sum += J_k^T H_k J_k (n rows of `stride`). Skips zero H_k.
/// \param h  nine numbers for each contact, row by row
void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end);
/// Row and column i of that matrix are added: row_l += (J^T H J)_il, column_l += (J^T H J)_li (n, padded).
void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end);

/// The kernels above in plain C++.
namespace scalar {
void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end);
void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end);
void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end);
void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd

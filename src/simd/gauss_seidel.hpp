#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/sliced_rows.hpp"

namespace palpate::simd {

/// A matrix and its block Gauss-Seidel smoother.
struct SmootherRows {
  SlicedRows rows;
  CouplingRows couplings;
  const float* diagonals;  ///< of the rows without couplings; slice_symmetric numbers for each slice
  const float* inverses;   ///< of the smoother's diagonal blocks, in the same layout
  const float* rotations;  ///< of rows; slot_values numbers for each slice
};

/// z += D^-1 (r - A z) in all rows of these slices at once. It is block Gauss-Seidel if no two of these rows
/// are coupled.
void relax_slices(const SmootherRows& rows, const float* r, Quad* z, const std::uint32_t* slices,
                  std::size_t count);
/// The same in a forward sweep from z = 0, where rows of later colours are still zero. In slices with
/// couplings, stores in `rest` r minus the part of A z from earlier colours, without couplings.
/// \param rest  slice_values numbers for each slice
void relax_from_zero(const SmootherRows& rows, const float* r, Quad* z, float* rest,
                     const std::uint32_t* slices, std::size_t count);
/// t = R^T (r - A z) in slices [begin, end) after a forward sweep from zero. Needs only the columns of later
/// colours, since the sweep left no residual at its time.
void rotated_residual(const SmootherRows& rows, const float* rest, const Quad* z, Quad* t, std::size_t begin,
                      std::size_t end);
/// z += R u in slices [begin, end).
void add_rotated(const SmootherRows& rows, const Quad* u, Quad* z, std::size_t begin, std::size_t end);
/// Stores z as values by slice. Returns the sum of r z over slices [begin, end).
double store_slices(const Quad* z, const float* r, float* values, std::size_t begin, std::size_t end);
/// coupling_products() of these couplings.
void listed_products(const CouplingTerm* couplings, const Quad* x, Quad* products, const std::uint32_t* list,
                     std::size_t count);

/// Rows, and the edges to which the rotation of each row is fitted.
struct RotationRows {
  const std::uint32_t* slot_begin;  ///< (n_slices + 1)
  const std::uint32_t* columns;     ///< 16 for each slot
  const float* edges;               ///< slice_values for each slot: e_ij, so that F = sum (x_j - x_i) e_ij^T
};
/// Finds for each row of slices [begin, end) the rotation nearest to its F, by eight Higham iterations. For
/// strains above about 0.1 the result is not exact. Where det F is not in (0.1, 10), it is the identity.
/// \param positions  (n_rows)
/// \param rotations  slot_values values for each slice
void find_rotations(const RotationRows& rows, const Quad* positions, float* rotations, std::size_t begin,
                    std::size_t end);

/// The kernels above in plain C++.
namespace scalar {
void relax_slices(const SmootherRows& rows, const float* r, Quad* z, const std::uint32_t* slices,
                  std::size_t count);
void relax_from_zero(const SmootherRows& rows, const float* r, Quad* z, float* rest,
                     const std::uint32_t* slices, std::size_t count);
void rotated_residual(const SmootherRows& rows, const float* rest, const Quad* z, Quad* t, std::size_t begin,
                      std::size_t end);
void add_rotated(const SmootherRows& rows, const Quad* u, Quad* z, std::size_t begin, std::size_t end);
double store_slices(const Quad* z, const float* r, float* values, std::size_t begin, std::size_t end);
void listed_products(const CouplingTerm* couplings, const Quad* x, Quad* products, const std::uint32_t* list,
                     std::size_t count);
void find_rotations(const RotationRows& rows, const Quad* positions, float* rotations, std::size_t begin,
                    std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd

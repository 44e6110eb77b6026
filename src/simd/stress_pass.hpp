#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/tissue.hpp>

#include "simd/element_pass.hpp"

namespace palpate::simd {

/// What a stress pass reads; arrays of (n_elements), rounded up to whole groups.
struct StressPass {
  const Padded3* displacements;  ///< (n_points), m, from rest
  const std::int32_t* corners;   ///< 4 an element
  std::array<const double*, 9> inverse_rest;
  const double* mu;      ///< Pa
  const double* lambda;  ///< Pa
};

/// Strain and stress of a group of elements, by column.
struct GroupStress {
  using Column = std::array<double, element_group>;
  alignas(64) std::array<Column, 9> gradient;  ///< F, row by row
  alignas(64) std::array<Column, 6> strain;    ///< Green's: xx, yy, zz, xy, yz, xz
  alignas(64) std::array<Column, 6> stress;    ///< Cauchy's, Pa
  alignas(64) Column energy_density;           ///< J/m^3
  alignas(64) Column volume_ratio;
  std::array<std::uint8_t, element_group> left;  ///< 1: not done, the caller must
};

/// Corotational elastic stress of the group of elements that begins at `begin` (fem/stress.hpp has the
/// formulas), as many at a time as a vector of double has lanes, with the rotations of element_pass(). What
/// is left to the caller is as there. The twin in plain C++ is fem/stress.cpp, equal to rounding.
void stress_pass(const StressPass& pass, std::size_t begin, GroupStress& found);

/// Eigenvalues of symmetric tensors, largest first, and unit eigenvectors in that order, the largest
/// component of each positive; NaN for a tensor that is not finite. Spans have one length. By Jacobi
/// rotations in lanes; returns how many, from the first, are done: whole groups of eight, none where the
/// processor has fewer than four lanes. The twin is fem/symmetric_eigen.cpp, equal to rounding.
std::size_t symmetric_eigen(std::span<const SymmetricTensor> tensors, std::span<Vec3> values,
                            std::span<std::array<Vec3, 3>> vectors);

}  // namespace palpate::simd

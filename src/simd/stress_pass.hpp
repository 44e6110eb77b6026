#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/tissue.hpp>

#include "simd/element_pass.hpp"

namespace palpate::simd {

/// Input of a stress pass. Arrays have n_elements entries, rounded up to whole groups.
struct StressPass {
  const Padded3* displacements;  ///< (n_points) displacements from rest, m
  const std::int32_t* corners;   ///< 4 for each element
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
  std::array<std::uint8_t, element_group> left;  ///< 1: left to the caller
};

/// Corotational elastic stress of the group of elements that begins at `begin` (formulas: fem/stress.hpp),
/// one element per lane. Computes rotations as element_pass() does, and leaves the same elements to the
/// caller. fem/stress.cpp is the same in plain C++, equal up to rounding.
void stress_pass(const StressPass& pass, std::size_t begin, GroupStress& found);

/// Eigenvalues of symmetric tensors, largest first, and unit eigenvectors in that order; the largest
/// component of each eigenvector is positive. NaN for a tensor that is not finite. All spans have the same
/// length. Uses Jacobi rotations in lanes. Returns how many tensors, from the first on, it has done: whole
/// groups of eight, or 0 on processors with fewer than four lanes. fem/symmetric_eigen.cpp is the same in
/// plain C++, equal up to rounding.
std::size_t symmetric_eigen(std::span<const SymmetricTensor> tensors, std::span<Vec3> values,
                            std::span<std::array<Vec3, 3>> vectors);

}  // namespace palpate::simd

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Floats per element for its stiffness blocks: 54, padded to whole vectors of four.
inline constexpr std::size_t block_stride = 56;

/// Part of negative eigenvalues that tets keep, as positive numbers, where the pressure of the volume is a
/// tension and they are not inverted (fem/hyperelastic.hpp, tangent()). Without, tets of too large a volume
/// have no stiffness against some changes of shape, so the first updates are far too large. With all of it,
/// tissue with tets of bad shape converges slowly.
inline constexpr double kept_part = 0.25;

/// Columns of the law of each element (fem/hyperelastic.hpp), in Pa unless noted: moduli of the first and the
/// second invariant and of the volume, ambient pressure; the unit vector of the fibres or zero, their
/// stiffness, exponent (no unit) and tension.
enum LawColumn : std::uint8_t {
  law_first,
  law_second,
  law_bulk,
  law_ambient,
  law_fibre_x,
  law_fibre_y,
  law_fibre_z,
  law_fibre_stiffness,
  law_fibre_exponent,
  law_tension,
  law_columns
};

/// Input and output of a hyperelastic pass. Arrays have one item for each element, in whole groups; laws and
/// blocks begin at element `first_law`.
struct HyperelasticPass {
  const Padded3* displacements;  ///< (n_points) displacements from rest, m
  const std::int32_t* corners;   ///< 4 for each element
  std::array<const double*, 9> inverse_rest;
  const double* volumes;  ///< at rest, m^3
  const double* factors;  ///< scale of the stiffness of each element
  std::array<const double*, law_columns> laws;
  std::size_t first_law;
  bool second;             ///< whether any element has a modulus of the second invariant
  bool fibres;             ///< whether any element has fibres
  double* forces;          ///< 4 x 4 for each element, from `begin` on: the force on corner i, and 0
  double* energies;        ///< J
  std::uint8_t* inverted;  ///< 1: the volume is not positive
  std::uint8_t* left;      ///< 1: left to the caller
  float* blocks;           ///< block_stride numbers for each element
};

/// Forces, energies and positive semi-definite stiffness of hyperelastic tets (formulas:
/// fem/hyperelastic.hpp), one per lane. Leaves the same elements to the caller as element_pass(). Singular
/// values follow from its rotation R: R^T F = V diag(s) V^T, by four sweeps of Jacobi rotations; most tets of
/// the stable neo-Hookean law need none (twist_lanes-inl.hpp). fem/hyperelastic.cpp is the same in plain C++,
/// equal up to rounding.
/// \param begin,end  elements; multiples of element_group
void hyperelastic_pass(const HyperelasticPass& pass, std::size_t begin, std::size_t end);

}  // namespace palpate::simd

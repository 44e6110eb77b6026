#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Doubles from the stiffness blocks of an element to those of the next: 54 in whole cache lines.
inline constexpr std::size_t block_stride = 56;

/// Columns of the law of each element (fem/hyperelastic.hpp), Pa where not said: moduli of the first and the
/// second invariant and of the volume; the unit vector of the fibres or zero, their stiffness, exponent (no
/// unit) and tension.
enum LawColumn : std::uint8_t {
  law_first,
  law_second,
  law_bulk,
  law_fibre_x,
  law_fibre_y,
  law_fibre_z,
  law_fibre_stiffness,
  law_fibre_exponent,
  law_tension,
  law_columns
};

/// What a hyperelastic pass reads and writes; arrays by element, in whole groups, but those of laws and
/// blocks, which begin at element `first_law`.
struct HyperelasticPass {
  const Padded3* displacements;  ///< (n_points), m, from rest
  const std::int32_t* corners;   ///< 4 an element
  std::array<const double*, 9> inverse_rest;
  const double* volumes;  ///< at rest, m^3
  const double* factors;  ///< of the stiffness
  std::array<const double*, law_columns> laws;
  std::size_t first_law;
  bool fibres;             ///< whether any element has some
  double* forces;          ///< from element `begin` on, 4 x 4 an element: force on corner i, and 0
  double* energies;        ///< J
  std::uint8_t* inverted;  ///< 1: no positive volume
  std::uint8_t* left;      ///< 1: not done, the caller must
  double* blocks;          ///< block_stride an element
};

/// Forces, energies and positive semi-definite stiffness of hyperelastic tets (fem/hyperelastic.hpp has the
/// formulas), as many at a time as a vector of double has lanes. What is left to the caller is as with
/// element_pass(), from whose rotation R the singular values follow: R^T F = V diag(s) V^T by four sweeps of
/// Jacobi rotations. The twin in plain C++ is fem/hyperelastic.cpp, equal to rounding.
/// \param begin,end  elements; multiples of element_group
void hyperelastic_pass(const HyperelasticPass& pass, std::size_t begin, std::size_t end);

}  // namespace palpate::simd

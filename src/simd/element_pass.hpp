#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Elements go in groups of so many: arrays per element have a multiple of that, the rest filled with zeros.
inline constexpr std::size_t element_group = 16;

/// What an element pass reads and writes; arrays of (n_elements), rounded up to whole groups, unless said.
struct ElementPass {
  const Padded3* displacements;  ///< (n_points), m, from rest
  const std::int32_t* corners;   ///< 4 an element
  std::array<const double*, 9> inverse_rest;
  const double* stiffness;        ///< mu V
  const double* ratios;           ///< lambda / mu
  const double* factors;          ///< of the stiffness
  std::array<double*, 9> turned;  ///< a_i = sqrt(factor mu V) R g_i of corners 1 to 3
  Quad* gradients;                ///< 4 an element: a_i of all corners, and the ratio
  double* forces;                 ///< from element `begin` on, 4 x 4 an element: force on corner i, and 0
  double* energies;               ///< J
  std::uint8_t* inverted;         ///< 1: no positive volume
  std::uint8_t* left;             ///< 1: not done, the caller must
};

/// Rotation, forces and turned gradients of elastic tets (fem/elements.hpp has the formulas), as many at a
/// time as a vector of double has lanes. An element that is flat, inverted or not finite is left: what the
/// pass writes of it is undefined then. Where the processor has fewer than four lanes all are left.
///
/// Rotations have a closed form. tr(R^T F) = l is the largest root of
///   g(l) = l^4 - 2 I l^2 - 8 J l + I^2 - 4 II,  I = |F|^2, II = |cof F|^2, J = det F
/// (Horn 1987, section 4: the largest eigenvalue of a 4x4 matrix, whose characteristic polynomial this is),
/// and R = dl / dF, since dR adds nothing to l. So with g(l) = 0 differentiated by F
///   R = ((l^2 + I) F + 2 l cof F - 2 F F^T F) / (l^3 - I l - 2 J),
/// where the denominator is (s1 + s2)(s2 + s3)(s3 + s1), of the singular values.
/// \param begin,end  elements; multiples of element_group
void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end);

/// What a stiffness pass reads and writes.
struct StiffnessPass {
  const Padded3* vectors;  ///< (n_points)
  const std::int32_t* corners;
  std::array<const double*, 9> turned;  ///< as the element pass leaves them
  const double* ratios;
  double* products;  ///< from element `begin` on, 4 x 4 an element: of corner i, and 0
};

/// K'_e x of each element, in double: with G = sum_j x_j a_j^T that is (r tr(G) I + G + G^T) a_i at corner i.
/// \param begin,end  elements; multiples of element_group
void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end);
namespace scalar {
void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end);
}

}  // namespace palpate::simd

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// Elements per group. Arrays by element are padded with zeros to whole groups.
inline constexpr std::size_t element_group = 16;

/// Input and output of an element pass. Arrays have n_elements entries, rounded up to whole groups, unless
/// noted.
struct ElementPass {
  const Padded3* displacements;  ///< (n_points) displacements from rest, m
  const std::int32_t* corners;   ///< 4 for each element
  std::array<const double*, 9> inverse_rest;
  const double* stiffness;        ///< mu V
  const double* ratios;           ///< lambda / mu
  const double* factors;          ///< scale of the stiffness of each element
  std::array<double*, 9> turned;  ///< a_i = sqrt(factor mu V) R g_i of corners 1 to 3
  Quad* gradients;                ///< 4 for each element: a_i of all corners, with the ratio as fourth value
  double* forces;                 ///< 4 x 4 for each element, from `begin` on: the force on corner i, and 0
  double* energies;               ///< J
  std::uint8_t* inverted;         ///< 1: the volume is not positive
  std::uint8_t* left;             ///< 1: left to the caller
};

/// Computes rotation, forces and rotated gradients of elastic tets (formulas: fem/elements.hpp), one per
/// lane. An element that is flat, inverted or not finite is left to the caller: its output is undefined.
/// Processors with fewer than four lanes leave all.
///
/// Rotations have a closed form. tr(R^T F) = l is the largest root of
///   g(l) = l^4 - 2 I l^2 - 8 J l + I^2 - 4 II,  I = |F|^2, II = |cof F|^2, J = det F
/// (Horn 1987, section 4: the largest eigenvalue of a 4x4 matrix, whose characteristic polynomial this is),
/// and R = dl / dF, since a change of R does not change l to first order. Differentiating g(l) = 0 by F gives
///   R = ((l^2 + I) F + 2 l cof F - 2 F F^T F) / (l^3 - I l - 2 J),
/// where the denominator is (s1 + s2)(s2 + s3)(s3 + s1) for singular values s.
/// \param begin,end  elements; multiples of element_group
void element_pass(const ElementPass& pass, std::size_t begin, std::size_t end);

/// Input and output of a stiffness pass.
struct StiffnessPass {
  const Padded3* vectors;  ///< (n_points)
  const std::int32_t* corners;
  std::array<const double*, 9> turned;  ///< as written by the element pass
  const double* ratios;
  double* products;  ///< 4 x 4 for each element, from `begin` on: the product at corner i, and 0
};

/// K'_e x of each element, in double: (r tr(G) I + G + G^T) a_i at corner i, with G = sum_j x_j a_j^T.
/// \param begin,end  elements; multiples of element_group
void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end);

/// Input and output of a tangent pass.
struct TangentPass {
  const Padded3* vectors;  ///< (n_points)
  const std::int32_t* corners;
  const float* blocks;  ///< block_stride numbers (hyperelastic_pass.hpp) for each element, from `begin` on
  double* products;     ///< as in StiffnessPass
};

/// K'_e x of each element in double, with the blocks (0,1), (0,2), (0,3), (1,2), (1,3), (2,3) of K'_e above
/// its diagonal: at corner i the sum of K'_ij (x_j - x_i). The twin has the same bits.
/// \param begin,end  elements; up to the next multiple of element_group after `end`, elements may be read and
///                   written
void tangent_pass(const TangentPass& pass, std::size_t begin, std::size_t end);

namespace scalar {
void tangent_pass(const TangentPass& pass, std::size_t begin, std::size_t end);
void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end);
}  // namespace scalar

}  // namespace palpate::simd

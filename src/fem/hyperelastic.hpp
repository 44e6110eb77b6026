#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <palpate/material.hpp>

#include "fem/matrix.hpp"

namespace palpate::fem {

/// A part of the stiffness of an element in a step: that of its elastic force, or that of its stiffness
/// damping.
enum class StiffnessPart : std::uint8_t { whole, elastic, damping };

/// A hyperelastic law of one element: with H = F - I, I1 = |F|^2, I2 = |cof F|^2 and J = det F its energy per
/// volume at rest is
///   first/2 (I1 - 3 - ln((I1 + 1) / 4)) + second/2 (I2 - 3) + bulk/2 (J - 1)^2
///   - (3/4 first + 2 second) (J - 1),
/// and of fibres along the unit vector `fibre`, with w = F fibre, I4 = |w|^2 and E = I4 - 1,
///   stiffness/(2 exponent) (exp(exponent E^2) - 1) where E > 0, and tension sqrt(I4).
/// Smith, de Goes & Kim, "Stable neo-Hookean flesh simulation", ACM TOG 37 (2018), eq. 14, is second = 0; its
/// term in (J - alpha)^2 with alpha = 1 + 3/4 first/bulk differs by a constant from ours, which is zero at
/// rest without cancellation. An ambient pressure p adds p (J - 1): over all elements of a body this is the
/// work against a pressure p on all of its surface. Fibres: Holzapfel, Gasser & Ogden, J. Elasticity 61
/// (2000), section 4. Deviations: for exponent E^2 > 16 the energy continues as its Taylor polynomial of
/// second order, so that no trial step overflows; sqrt(I4) is sqrt(I4 + 1e-6), so that a crushed fibre has a
/// tangent.
struct HyperelasticLaw {
  double first = 0.0;   ///< Pa
  double second = 0.0;  ///< Pa
  double bulk = 0.0;    ///< Pa
  Vec3 fibre{};         ///< zero: no fibres
  double fibre_stiffness = 0.0;
  double fibre_exponent = 0.0;
  double tension = 0.0;  ///< Pa
  double ambient = 0.0;  ///< Pa

  /// The derivative of the energy by J is bulk (J - 1) minus this.
  [[nodiscard]] constexpr double rest_pressure() const { return 0.75 * first + 2.0 * second - ambient; }
};

/// Moduli of the two invariants. For small strains the shear modulus is mu = 3/4 first + second.
struct InvariantModuli {
  double first = 0.0;
  double second = 0.0;
};
[[nodiscard]] InvariantModuli invariant_moduli(const Material& material);
/// lambda of Lame at rest is bulk - 5/8 first.
[[nodiscard]] constexpr double bulk_of(double lambda, double first) {
  return lambda + 0.625 * first;
}

/// Energy per volume and first Piola-Kirchhoff stress P = d energy / dF.
struct HyperelasticResponse {
  double energy_density = 0.0;  ///< J/m^3
  Matrix3 stress;               ///< Pa
};
/// \param h  F - I
[[nodiscard]] HyperelasticResponse respond(const HyperelasticLaw& law, const Matrix3& h);

/// J - 1 without cancellation near rest.
/// \param h  F - I
[[nodiscard]] double volume_change(const Matrix3& h, const Matrix3& cofactors_of_h);

/// State of the fibres at F: w, their energy per volume, and coefficients of their stress c w f^T and of its
/// derivative, (along w w^T + c I) along f f^T.
struct FibreState {
  Vec3 stretched;
  double energy = 0.0;
  double stress = 0.0;
  double along = 0.0;
};
[[nodiscard]] FibreState fibre_state(const HyperelasticLaw& law, const Matrix3& h);

/// The derivative of the stress, in the frames of the singular value decomposition F = U diag(s) V^T, without
/// negative eigenvalues: for dF = U A V^T it is U B V^T with
///   B_pp = sum_q stretch_pq A_qq,  B_pq = same_r A_pq + other_r A_qp,  r the axis that is neither p nor q.
/// Eigenvalues are those of Smith, de Goes & Kim, "Analytic eigensystems for isotropic distortion energies",
/// ACM TOG 38 (2019), section 4: same - other of twists, same + other of flips, three of `stretch`. U and V
/// are orthogonal with equal signs, and s3 < 0 where F is inverted. Fibres add (w w^T fibre_along + I
/// fibre_across) along f f^T.
struct HyperelasticTangent {
  Matrix3 left;   ///< U
  Matrix3 right;  ///< V
  SymmetricMatrix3 stretch;
  Vec3 same;
  Vec3 other;
  Vec3 stretched_fibre;  ///< w
  double fibre_along = 0.0;
  double fibre_across = 0.0;
};
/// \param kept  where F is not inverted and the pressure of J is a tension, negative eigenvalues are replaced
/// by
///              minus this part of them, elsewhere by zero (Chen et al., "Stabler Neo-Hookean simulation:
///              absolute eigenvalue filtering for projected Newton", SIGGRAPH 2024, keep all everywhere)
[[nodiscard]] HyperelasticTangent tangent(const HyperelasticLaw& law, const Matrix3& h, double kept);

/// The change dP of the first Piola-Kirchhoff stress for a change dF of the deformation gradient. `fibre` is
/// the unit vector of the fibres at rest.
[[nodiscard]] Matrix3 stress_change_of(const HyperelasticTangent& tangent, const Vec3& fibre,
                                       const Matrix3& gradient_change);

/// The six stiffness blocks of an element above its diagonal: corners (0,1), (0,2), (0,3), (1,2), (1,3),
/// (2,3). Each has nine numbers row by row; rows belong to the first corner. A block on the diagonal is minus
/// the sum of the others of its row.
inline constexpr std::size_t tangent_blocks = 6;
inline constexpr std::size_t tangent_values = 9 * tangent_blocks;
/// Place of block (i, j), i < j.
[[nodiscard]] constexpr std::size_t block_place(int i, int j) {
  return 9 * static_cast<std::size_t>(i == 0 ? j - 1 : i + j);
}

/// \param block_between  function: the block per volume of two of the corners 1 to 3, numbered from 0
/// \param scale          of all blocks: volume times factor
template <class BlockBetween>
void put_blocks(const BlockBetween& block_between, double scale, std::span<double, tangent_values> blocks) {
  std::array<Matrix3, 3> sums;  // of column j over rows 1 to 3
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i; j < 3; ++j) {
      const Matrix3 block = block_between(i, j);
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          sums[j](r, c) += block(r, c);
          if (i == j) continue;
          sums[i](r, c) += block(c, r);
          blocks[block_place(static_cast<int>(i) + 1, static_cast<int>(j) + 1) +
                 static_cast<std::size_t>(3 * r + c)] = scale * block(r, c);
        }
      }
    }
  }
  for (int j = 0; j < 3; ++j) {
    const Matrix3& sum = sums[static_cast<std::size_t>(j)];
    for (std::size_t k = 0; k < 9; ++k) blocks[block_place(0, j + 1) + k] = -scale * sum.values[k];
  }
}
/// \param gradients  of the shape functions of corners 1 to 3 at rest
void put_blocks(const HyperelasticTangent& tangent, const Vec3& fibre, const std::array<Vec3, 3>& gradients,
                double scale, std::span<double, tangent_values> blocks);

}  // namespace palpate::fem

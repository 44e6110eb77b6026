#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// A symmetric 3x3 tensor, components in the order of VTK.
struct SymmetricTensor {
  double xx = 0.0;  ///< component of row x, column x
  double yy = 0.0;  ///< component of row y, column y
  double zz = 0.0;  ///< component of row z, column z
  double xy = 0.0;  ///< component of row x, column y, and its mirror
  double yz = 0.0;  ///< component of row y, column z, and its mirror
  double xz = 0.0;  ///< component of row x, column z, and its mirror
  friend bool operator==(const SymmetricTensor&, const SymmetricTensor&) = default;
};

/// A 3x3 tensor, row by row.
using Tensor = std::array<double, 9>;

/// Strain and stress of the tissue, a row for each tet or each point. Rigid bodies have none: their rows are
/// zero, with volume ratio 1 and the identity as deformation gradient.
///
/// The stress is the elastic one that gives the forces of the tets: the derivative of their energy
/// (docs/materials.md), without damping. With P the derivative by the deformation gradient F, and J = det F,
/// the Cauchy stress is P F^T / J: force per deformed area, in world axes. Where J <= 0 (a flat or inverted
/// tet) it is not defined: `stress` and the quantities derived from it are NaN.
struct TissueState {
  std::vector<Tensor> deformation_gradient;  ///< (n) F, from the shape at rest
  std::vector<SymmetricTensor> strain;       ///< (n) Green's: (F^T F - I) / 2
  std::vector<SymmetricTensor> stress;       ///< (n) Cauchy's, Pa; tension is positive
  std::vector<double> von_mises;             ///< (n) sqrt(3/2) |deviator of the stress|, Pa
  std::vector<double> pressure;              ///< (n) -trace(stress) / 3, Pa
  std::vector<Vec3> principal_stress;        ///< (n x 3) eigenvalues of the stress, largest first, Pa
  std::vector<std::array<Vec3, 3>> principal_directions;  ///< (n x 3 x 3) unit eigenvectors, in that order
  std::vector<double> energy_density;                     ///< (n) elastic energy per volume at rest, J/m^3
  std::vector<SymmetricTensor> plastic_strain;            ///< (n) in the corotated frame of the tet
  std::vector<double> volume_ratio;                       ///< (n) J
  [[nodiscard]] std::size_t size() const { return stress.size(); }  ///< number of rows n
};

}  // namespace palpate

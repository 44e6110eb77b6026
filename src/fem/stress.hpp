#pragma once

#include <palpate/tissue.hpp>

#include "fem/elements.hpp"
#include "fem/matrix.hpp"

namespace palpate::fem {

/// Strain and stress of one element; see TissueState. NaN stress where J <= 0.
struct ElementStress {
  Matrix3 deformation_gradient;
  SymmetricMatrix3 strain;
  SymmetricMatrix3 stress;
  SymmetricMatrix3 plastic_strain;
  double energy_density = 0.0;
  double volume_ratio = 1.0;
};

/// The Cauchy stress P F^T / J of the energy that the forces of an element are the derivative of
/// (elements.hpp):
///   P = R (2 mu (e - [w]_x) + lambda tr(e) I),  e = R^T F - I - p.
/// or that of its hyperelastic law (hyperelastic.hpp).
/// P F^T is symmetric: the energy does not change with a rotation of the whole.
[[nodiscard]] ElementStress stress_of(const ElementDeformation& element);
/// The same of an energy density and a first Piola-Kirchhoff stress that are given: of a smoothed tet, where
/// P F^T is symmetric to the order of the method, and its symmetric part is taken.
[[nodiscard]] ElementStress stress_of(const ElementDeformation& element,
                                      const HyperelasticResponse& response);

[[nodiscard]] double von_mises(const SymmetricMatrix3& stress);

/// In the order of VTK, and back.
[[nodiscard]] constexpr SymmetricTensor to_tensor(const SymmetricMatrix3& a) {
  return {a.xx, a.yy, a.zz, a.xy, a.yz, a.xz};
}
[[nodiscard]] constexpr SymmetricMatrix3 to_matrix(const SymmetricTensor& a) {
  return {a.xx, a.yy, a.zz, a.xy, a.xz, a.yz};
}

}  // namespace palpate::fem

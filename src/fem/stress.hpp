#pragma once

#include <palpate/tissue.hpp>

#include "fem/elements.hpp"
#include "fem/matrix.hpp"

namespace palpate::fem {

/// Strain and stress of one element; see TissueState. The stress is NaN where J <= 0.
struct ElementStress {
  Matrix3 deformation_gradient;
  SymmetricMatrix3 strain;
  SymmetricMatrix3 stress;
  SymmetricMatrix3 plastic_strain;
  double energy_density = 0.0;
  double volume_ratio = 1.0;
};

/// Strain and Cauchy stress P F^T / J of an element, where P is its first Piola-Kirchhoff stress. For a
/// corotated element (elements.hpp)
///   P = R (2 mu (e - [w]_x) + lambda tr(e) I),  e = R^T F - I - p;
/// for others P follows from the hyperelastic law (hyperelastic.hpp). The stress of Maxwell elements is added
/// (first_piola_stress). P F^T is symmetric, since the energy is invariant under rotations.
[[nodiscard]] ElementStress stress_of(const ElementDeformation& element);
/// stress_of() for a given energy density and first Piola-Kirchhoff stress, of a smoothed tet. There P F^T
/// is symmetric only to the order of the method; its symmetric part is used.
[[nodiscard]] ElementStress stress_of(const ElementDeformation& element,
                                      const HyperelasticResponse& response);

/// Energy density and first Piola-Kirchhoff stress of the law, without viscosity.
[[nodiscard]] HyperelasticResponse elastic_response(const ElementDeformation& element);
/// elastic_response() plus the current stresses of Maxwell elements.
[[nodiscard]] HyperelasticResponse whole_response(const ElementDeformation& element);

/// The elastic stress in the rotated frame of the element, the symmetric part of R^T P (Biot's), without
/// viscosity and active fibres, Pa.
[[nodiscard]] SymmetricMatrix3 biot_stress(const ElementDeformation& element);
/// P of a stress T that is fixed in the rotated frame: P = R (T + [w]_x), the derivative of T : R^T F, with w
/// = plastic_twist() for T. It exerts no torque.
[[nodiscard]] Matrix3 first_piola_stress(const SymmetricMatrix3& biot, const Matrix3& gradient,
                                         const Matrix3& rotation);
/// Elastic energy per volume at rest, with that of Maxwell elements, J/m^3.
[[nodiscard]] double energy_density_of(const ElementDeformation& element);

[[nodiscard]] double von_mises(const SymmetricMatrix3& stress);

/// Converts to the component order of VTK, and back.
[[nodiscard]] constexpr SymmetricTensor to_tensor(const SymmetricMatrix3& a) {
  return {a.xx, a.yy, a.zz, a.xy, a.yz, a.xz};
}
[[nodiscard]] constexpr SymmetricMatrix3 to_matrix(const SymmetricTensor& a) {
  return {a.xx, a.yy, a.zz, a.xy, a.xz, a.yz};
}

}  // namespace palpate::fem

#pragma once

#include <optional>

#include <palpate/material.hpp>

#include "fem/matrix.hpp"

namespace palpate::fem {

/// When and how fast an element yields; see Material.
struct Plasticity {
  std::optional<double> yield{};    ///< empty: never yields
  double creep = 0.0;               ///< 1/s
  std::optional<double> maximum{};  ///< empty: no bound
};

/// Frobenius norm, sqrt(a : a).
[[nodiscard]] double norm(const SymmetricMatrix3& a);

/// The symmetric part of R^T F - I for the deformation gradient F and its rotation R: the whole strain of an
/// element. Exactly zero for F = R = I.
[[nodiscard]] SymmetricMatrix3 corotated_strain(const Matrix3& f, const Matrix3& rotation);

/// Plastic strain after a time step, from that before it and the whole strain at its end.
///
/// Mueller & Gross, "Interactive Virtual Materials", Graphics Interface 2004, section 5 (plasticity): with
/// elastic = total - plastic, where |elastic| > yield: plastic += min(1, h creep) elastic; where then
/// |plastic| > maximum: plastic *= maximum / |plastic|.
/// Deviations: norms are Frobenius norms of the tensors (theirs, of the six-vector, depends on the axes);
/// flow that would raise the elastic energy mu |elastic|^2 + lambda/2 tr^2(elastic) is left out, which only
/// the bound can cause: plastic flow never adds energy.
[[nodiscard]] SymmetricMatrix3 plastic_flow(const SymmetricMatrix3& plastic, const SymmetricMatrix3& total,
                                            const Plasticity& plasticity, double time_step, double mu,
                                            double lambda);

/// The vector w: the part of dR in the stress of an element with plastic strain p. With S = R^T F and e = S -
/// I - p, the derivative of mu |e|^2 + lambda/2 tr^2(e) by F at fixed p is
///   R (2 mu (e - [w]_x) + lambda tr(e) I),  (tr(S) I - S) w = vee(S p - p S).
/// Derivation: dF = dR S + R dS with R^T dR = [o]_x gives (tr(S) I - S) o = vee(A - A^T) for A = R^T dF, and
/// e : dS = e : A - e : [o]_x S. Mueller & Gross leave w out, so that their plastic forces have a torque
/// unless S and p have the same axes (w = 0). With w the torque is zero. |w| <= |p| / sqrt(2) holds if S is
/// positive definite, and is enforced elsewhere, where the energy has a kink. w = 0 if the matrix has no
/// finite inverse.
[[nodiscard]] Vec3 plastic_twist(const SymmetricMatrix3& stretch, const SymmetricMatrix3& plastic);

/// The same for an element with the deformation gradient F and its rotation.
[[nodiscard]] Vec3 twist_of(const Matrix3& f, const Matrix3& rotation, const SymmetricMatrix3& plastic);

}  // namespace palpate::fem

#pragma once

#include "fem/coupling.hpp"
#include "fem/matrix.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {

/// Force of one contact over a step as a function of the relative velocity u of point and tet at the END of
/// the step. With R = damping + time_step * stiffness:
/// - normal force f_n = stiffness * depth - R (u . direction) where that is positive, else the contact is
///   open: no force at all;
/// - friction by a spring and damper across the direction, p = -stiffness * slip - R u_across. |p| at most
///   mu f_n: the contact sticks with force p; else it slides with mu f_n p / |p| (Coulomb; return mapping as
///   in Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991)).
struct ContactLaw {
  double stiffness = 0.0;  ///< N/m
  double damping = 0.0;    ///< N s/m
  double depth = 0.0;      ///< at the start of the step, m; negative: a gap
  Vec3 slip{};             ///< of the friction spring at the start of the step, m; across the direction
  Vec3 direction{};        ///< unit; out of the penetrated body

  [[nodiscard]] double resistance(double time_step) const { return damping + time_step * stiffness; }
};

/// What all contacts of a step have in common.
struct StepFriction {
  double coefficient = 0.0;  ///< Coulomb's mu, >= 0
  double time_step = 0.0;    ///< s, > 0
};

/// Force of a law at a relative velocity.
struct ContactForce {
  double normal = 0.0;  ///< >= 0, N
  Vec3 pull{};          ///< p: the friction without its bound, N
  Vec3 friction{};      ///< N
  [[nodiscard]] Vec3 whole(const Vec3& direction) const { return normal * direction + friction; }
};
[[nodiscard]] ContactForce contact_force(const ContactLaw& law, const StepFriction& step, const Vec3& u);

/// Force with another bound of the friction (N) than the normal force gives. With given bounds the forces of
/// all contacts are the derivative of a convex function of the velocities, which a line search can use.
[[nodiscard]] Vec3 force_with_bound(const ContactLaw& law, const StepFriction& step, const Vec3& u,
                                    double bound);

/// -df/du of contact_force(), N s/m; unsymmetric where the contact slides. With s = R mu f_n / |p|, n the
/// direction and t = p / |p|: R n n^T + s (I - n n^T - t t^T) + mu R t n^T.
[[nodiscard]] Matrix3 derivative(const ContactLaw& law, const StepFriction& step, const Vec3& u);
/// The same of force_with_bound(): symmetric, positive semi-definite.
[[nodiscard]] Matrix3 derivative_with_bound(const ContactLaw& law, const StepFriction& step, const Vec3& u,
                                            double bound);

/// Puts force and stiffness of a law at a velocity into a coupling: exact there, with R n n^T + s (I - n n^T)
/// as its damping, which is symmetric and majorises the friction (iteratively reweighted least squares); all
/// zero where the contact is open. Its stiffness is set to zero.
void linearise(const ContactLaw& law, const StepFriction& step, const Vec3& u, Coupling& coupling);

}  // namespace palpate::fem

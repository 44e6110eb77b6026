#pragma once

#include <span>

#include "fem/coupling.hpp"
#include "fem/matrix.hpp"
#include "geometry/vector.hpp"
#include "simd/aligned.hpp"
#include "simd/contact_laws.hpp"

namespace palpate::fem {

/// Force of one contact over a step, as a function of the relative velocity u of point and tet at the END of
/// the step. With R = damping + time_step * stiffness:
/// - normal force f_n = stiffness * depth - R (u . direction) if that is positive; otherwise the contact is
///   open and has no force;
/// - friction by a spring and damper across the direction, p = -stiffness * slip - R u_across. If |p| <= mu
///   f_n, the contact sticks with force p. Otherwise it slides with mu f_n p / |p| (Coulomb; return mapping
///   as in Alart & Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991)).
struct ContactLaw {
  double stiffness = 0.0;  ///< N/m
  double damping = 0.0;    ///< N s/m
  double depth = 0.0;      ///< at the start of the step, m; negative: a gap
  Vec3 slip{};             ///< of the friction spring at the start of the step, m; across the direction
  Vec3 direction{};        ///< unit; out of the penetrated body

  [[nodiscard]] double resistance(double time_step) const { return damping + time_step * stiffness; }
};

/// Data common to all contacts of a step.
struct StepFriction {
  double coefficient = 0.0;  ///< Coulomb's mu, >= 0
  double time_step = 0.0;    ///< s, > 0
};

/// Force of a law at a relative velocity.
struct ContactForce {
  double normal = 0.0;  ///< >= 0, N
  Vec3 pull{};          ///< p: friction force before it is limited to mu f_n, N
  Vec3 friction{};      ///< N
  [[nodiscard]] Vec3 whole(const Vec3& direction) const { return normal * direction + friction; }
};
[[nodiscard]] ContactForce contact_force(const ContactLaw& law, const StepFriction& step, const Vec3& u);

/// A function of u whose negative derivative is the force of the law with a fixed friction bound. Convex; N
/// m/s.
[[nodiscard]] double contact_potential(const ContactLaw& law, double time_step, double friction_bound,
                                       const Vec3& u);

/// Stores laws in the layout of simd/contact_laws.hpp: whole groups, padded with zeros. O(laws).
void put_in_rows(std::span<const ContactLaw> laws, double time_step, simd::AlignedVector<double>& rows);

/// Linearises a law at a velocity u into a coupling, whose force is exact at u. The damping R n n^T + s (I -
/// n n^T) is symmetric and majorises the friction (iteratively reweighted least squares). The stiffness is
/// zero; for an open contact everything is.
void linearise(const ContactLaw& law, const StepFriction& step, const Vec3& u, Coupling& coupling);

}  // namespace palpate::fem

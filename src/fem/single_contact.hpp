#pragma once

#include <palpate/types.hpp>

#include "fem/contact_law.hpp"
#include "fem/matrix.hpp"

namespace palpate::fem {

/// Finds the force f of one contact whose relative velocity depends linearly on it: f is the force of the law
/// at the velocity u = free + response f. Open, sticking and sliding are tried one after the other. For a
/// sliding contact, the direction of its friction is the zero of a function on the unit circle, which
/// bisection finds. So it cannot cycle between sticking and sliding, as Newton's method can.
///
/// With a large coefficient of friction and a response that couples normal and tangential directions
/// strongly, there may be several such forces, or none (Painleve's paradox). Then this is the one whose
/// friction has the direction closest to that of `last`, or a force that only obeys the friction bound.
/// \param response  symmetric positive semi-definite, m/(N s)
/// \param last      N
[[nodiscard]] Vec3 single_contact_force(const ContactLaw& law, const StepFriction& step,
                                        const Matrix3& response, const Vec3& free, const Vec3& last);

}  // namespace palpate::fem

#pragma once

#include <array>
#include <span>

#include "fem/hyperelastic.hpp"

namespace palpate::fem {

/// dP/dF: row 3 i + c belongs to P_ic, column 3 j + d to F_jd.
using WholeTangent = std::array<std::array<double, 9>, 9>;

/// The whole tangent of tissue whose fibres pull. tangent() drops negative eigenvalues of the law without its
/// fibres. But where the tension of fibres is in balance with compressed tissue, they belong together: the
/// whole resists a rotation hardly at all, each part alone much. With the parts, Newton's method went a small
/// fraction of the way in each update.
///
/// The derivative of P = F S is dP = F dS + dF S. Only the second term can be negative by much: here S has no
/// negative eigenvalues, after fibres and tissue are added. Returns false, with an undefined result, if it is
/// not positive semi-definite all the same, or nothing pulls.
bool pulled_tangent(const HyperelasticLaw& law, const Matrix3& h, WholeTangent& result);

/// As the function of the same name for HyperelasticTangent.
[[nodiscard]] Matrix3 stress_change_of(const WholeTangent& tangent, const Matrix3& gradient_change);
/// a : dP/dF : b for two gradients of shape functions at rest: the stiffness block of two points per volume.
[[nodiscard]] Matrix3 block_of(const WholeTangent& tangent, const Vec3& a, const Vec3& b);
/// Blocks as put_blocks(), of pulled_tangent(); none where it returns false.
bool put_pulled_blocks(const HyperelasticLaw& law, const Matrix3& h, const std::array<Vec3, 3>& gradients,
                       double scale, std::span<double, tangent_values> blocks);

}  // namespace palpate::fem

#pragma once

#include <array>
#include <span>

#include "fem/hyperelastic.hpp"

namespace palpate::fem {

/// Blocks as put_blocks(), of the whole tangent of an element whose fibres pull. put_blocks() drops negative
/// eigenvalues of the law without its fibres. But where the tension of fibres is in balance with compressed
/// tissue, they belong together: the whole resists a rotation hardly at all, each part alone much. With the
/// parts, Newton's method went a small fraction of the way in each update.
///
/// The derivative of P = F S is dP = F dS + dF S. Only the second term can be negative by much: here S has no
/// negative eigenvalues, after fibres and tissue are added. Returns false, with no blocks, if the result is
/// not positive semi-definite all the same, or nothing pulls.
bool put_pulled_blocks(const HyperelasticLaw& law, const Matrix3& h, const std::array<Vec3, 3>& gradients,
                       double scale, std::span<double, tangent_values> blocks);

}  // namespace palpate::fem

#include "fem/linear_system.hpp"

#include <cmath>
#include <utility>

namespace palpate::fem {
namespace {

constexpr std::size_t point_grain = 256;

/// Inverse of a positive definite matrix A = L L^T as G^T G with G = L^-1, which stays positive definite
/// under rounding however stiff a contact is in one direction; where rounding leaves no L, the inverse of the
/// diagonal.
SymmetricMatrix3 positive_inverse(const SymmetricMatrix3& a) {
  const SymmetricMatrix3 diagonal{1.0 / a.xx, 1.0 / a.yy, 1.0 / a.zz, 0.0, 0.0, 0.0};
  const double l00 = std::sqrt(a.xx);
  const double l10 = a.xy / l00;
  const double l20 = a.xz / l00;
  const double pivot1 = a.yy - l10 * l10;
  if (!(pivot1 > 0.0)) return diagonal;
  const double l11 = std::sqrt(pivot1);
  const double l21 = (a.yz - l20 * l10) / l11;
  const double pivot2 = a.zz - l20 * l20 - l21 * l21;
  if (!(pivot2 > 0.0)) return diagonal;
  const double g00 = 1.0 / l00;
  const double g11 = 1.0 / l11;
  const double g22 = 1.0 / std::sqrt(pivot2);
  const double g10 = -l10 * g00 * g11;
  const double g21 = -l21 * g11 * g22;
  const double g20 = -(l20 * g00 + l21 * g10) * g22;
  return {g00 * g00 + g10 * g10 + g20 * g20,
          g11 * g11 + g21 * g21,
          g22 * g22,
          g10 * g11 + g20 * g21,
          g20 * g22,
          g21 * g22};
}

}  // namespace

LinearSystem::LinearSystem(const BlockMatrix& blocks, CouplingSystem& couplings,
                           std::vector<std::uint8_t> free)
    : blocks_(&blocks), couplings_(&couplings), free_(std::move(free)), inverse_diagonal_(free_.size()) {}

void LinearSystem::update_preconditioner(const parallel::Threads& threads) {
  parallel::for_each(threads, size(), point_grain, [&](std::size_t i) {
    if (free_[i] == 0) return;
    const auto row = static_cast<Index>(i);
    const Matrix3 b = blocks_->diagonal_block(row);
    const SymmetricMatrix3 symmetric{b(0, 0), b(1, 1), b(2, 2), b(0, 1), b(0, 2), b(1, 2)};
    inverse_diagonal_[i] = positive_inverse(symmetric + couplings_->diagonal_block(row));
  });
}

void LinearSystem::multiply(const parallel::Threads& threads, std::span<const Vec3> x, std::span<Vec3> y) {
  couplings_->multiply(threads, x);
  parallel::for_each(threads, size(), point_grain, [&](std::size_t i) {
    const auto row = static_cast<Index>(i);
    y[i] = free_[i] != 0 ? blocks_->row_product(row, x) + couplings_->row_product(row) : Vec3{};
  });
}

}  // namespace palpate::fem

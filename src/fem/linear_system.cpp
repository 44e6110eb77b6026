#include "fem/linear_system.hpp"

#include <cmath>
#include <utility>

namespace palpate::fem {
namespace {

constexpr std::size_t point_grain = 256;

SymmetricMatrix3 diagonal_inverse(const SymmetricMatrix3& a) {
  return {1.0 / a.xx, 1.0 / a.yy, 1.0 / a.zz, 0.0, 0.0, 0.0};
}

/// Inverse of a positive definite matrix A = L L^T as G^T G with G = L^-1, which stays positive definite
/// under rounding however stiff a contact is in one direction; where rounding leaves no L, the inverse of the
/// diagonal.
SymmetricMatrix3 positive_inverse(const SymmetricMatrix3& a) {
  const double g00 = 1.0 / std::sqrt(a.xx);
  const double l10 = a.xy * g00;
  const double l20 = a.xz * g00;
  const double pivot1 = a.yy - l10 * l10;
  if (!(pivot1 > 0.0)) return diagonal_inverse(a);
  const double g11 = 1.0 / std::sqrt(pivot1);
  const double l21 = (a.yz - l20 * l10) * g11;
  const double pivot2 = a.zz - l20 * l20 - l21 * l21;
  if (!(pivot2 > 0.0)) return diagonal_inverse(a);
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
    : blocks_(&blocks),
      couplings_(&couplings),
      free_(std::move(free)),
      masses_(free_.size(), 1.0),
      inverse_masses_(free_.size(), 0.0),
      inverse_diagonal_(3 * free_.size()),
      partial_(parallel::chunk_count(free_.size(), point_grain)) {}

void LinearSystem::update_preconditioner(const parallel::Threads& threads) {
  parallel::for_each(threads, size(), point_grain, [&](std::size_t i) {
    if (free_[i] == 0) return;
    const auto row = static_cast<Index>(i);
    masses_[i] = blocks_->diagonal()[i];
    inverse_masses_[i] = 1.0 / masses_[i];
    const SymmetricMatrix3 p =
        positive_inverse(blocks_->diagonal_block(row) + couplings_->diagonal_block(row));
    inverse_diagonal_[3 * i] = {p.xx, p.xy, p.xz, 0.0};
    inverse_diagonal_[3 * i + 1] = {p.xy, p.yy, p.yz, 0.0};
    inverse_diagonal_[3 * i + 2] = {p.xz, p.yz, p.zz, 0.0};
  });
}

void LinearSystem::update_coarse(const parallel::Threads& threads, CoarseSpace& coarse,
                                 std::span<const Vec3> positions) const {
  coarse.update(threads, *blocks_, *couplings_, positions);
}

double LinearSystem::multiply(const parallel::Threads& threads, std::span<const simd::Padded3> x,
                              std::span<simd::Padded3> y) {
  couplings_->multiply(threads, x);
  const simd::BlockRows blocks = blocks_->rows();
  const simd::CouplingRows couplings = couplings_->rows();
  parallel::for_chunks(
      threads, size(), point_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        partial_[chunk] = simd::multiply_rows(blocks, couplings, x.data(), y.data(), begin, end);
      });
  double sum = 0.0;
  for (const double part : partial_) sum += part;
  return sum;
}

}  // namespace palpate::fem

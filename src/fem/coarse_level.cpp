#include "fem/coarse_level.hpp"

#include <algorithm>
#include <utility>

#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t level_node_grain = 32;
constexpr int cycles = 2;  // Gauss-Seidel cycles in a solve of a level

}  // namespace

template <std::size_t N, std::size_t M>
void store_padded(const Dense<N, M>& block, float* place) {
  constexpr std::size_t stride = N == 3 ? 4 : 8;
  for (std::size_t j = 0; j < M; ++j) {
    for (std::size_t i = 0; i < stride; ++i)
      place[stride * j + i] = i < N ? static_cast<float>(block[M * i + j]) : 0.0F;
  }
}

template <std::size_t N, std::size_t M>
PaddedBlocks padded(const BlockRows<N, M>& rows) {
  constexpr std::size_t size = (N == 3 ? 4 : 8) * M;
  PaddedBlocks result;
  result.begin = rows.begin;
  result.columns = rows.columns;
  result.blocks.resize(size * rows.blocks.size());
  for (std::size_t k = 0; k < rows.blocks.size(); ++k)
    store_padded<N, M>(rows.blocks[k], result.blocks.data() + size * k);
  return result;
}

CoarseLevel::CoarseLevel(BlockRows<6, 6> bodies)
    : bodies_(std::move(bodies)), changed_(bodies_.size(), 1), inverses_(simd::six_by_six * bodies_.size()) {
  const std::size_t count = bodies_.size();
  off_diagonal_.blocks.resize(simd::six_by_six * (bodies_.blocks.size() - count));
  for (std::size_t row = 0; row < count; ++row) {
    for (std::uint32_t k = bodies_.begin[row]; k < bodies_.begin[row + 1]; ++k) {
      if (bodies_.columns[k] == row) continue;
      store_padded<6, 6>(bodies_.blocks[k],
                         off_diagonal_.blocks.data() + simd::six_by_six * off_diagonal_.columns.size());
      off_diagonal_.columns.push_back(bodies_.columns[k]);
    }
    off_diagonal_.begin.push_back(static_cast<std::uint32_t>(off_diagonal_.columns.size()));
  }
  right_side_.resize(count);
  solution_.resize(count);
  residual_.resize(count);
  change_.resize(count);
}

void CoarseLevel::connect(const BlockRows<6, 6>& transfer, std::size_t next_count) {
  transfer_ = padded(transfer);
  restriction_ = padded(transposed(transfer, next_count));
  std::vector<std::uint32_t> next(restriction_.begin.begin(), restriction_.begin.end() - 1);
  restriction_of_.clear();
  for (const std::uint32_t column : transfer.columns) restriction_of_.push_back(next[column]++);
}

simd::SixMatrix CoarseLevel::matrix() const {
  return {
      .first = off_diagonal_.rows(), .second = coupled_off_diagonal_.rows(), .inverses = inverses_.data()};
}

void CoarseLevel::solve(const parallel::Threads& threads, std::span<CoarseLevel> below) {
  if (below.empty()) {
    factor_.solve(right_side_, solution_);
    return;
  }
  const simd::SixMatrix a = matrix();
  simd::relax_forward(a, right_side_.data(), solution_.data(), 0, size());
  correct(threads, below, solution_);
  simd::relax_backward(a, right_side_.data(), solution_.data(), 0, size());
  for (int cycle = 1; cycle < cycles; ++cycle) {
    std::ranges::copy(solution_, change_.begin());
    simd::relax_forward_from(a, right_side_.data(), solution_.data(), 0, size());
    for (std::size_t i = 0; i < size(); ++i) {
      for (std::size_t k = 0; k < 6; ++k)
        change_[i].values[k] = solution_[i].values[k] - change_[i].values[k];
    }
    correct(threads, below, change_);
    simd::relax_backward(a, right_side_.data(), solution_.data(), 0, size());
  }
}

/// Adds the correction from the levels below to the solution. The correction is for the residual after a
/// forward sweep that made this change.
void CoarseLevel::correct(const parallel::Threads& threads, std::span<CoarseLevel> below,
                          std::span<const simd::Six> change) {
  const simd::SixMatrix a = matrix();
  CoarseLevel& next = below.front();
  parallel::for_chunks(threads, size(), level_node_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::residual_above(a, change.data(), residual_.data(), begin, end);
                       });
  parallel::for_chunks(
      threads, next.size(), level_node_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
        simd::multiply_six(restriction_.rows(), residual_.data(), next.right_side_.data(), begin, end);
      });
  next.solve(threads, below.subspan(1));
  parallel::for_chunks(threads, size(), level_node_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t) {
                         simd::add_six(transfer_.rows(), next.solution_.data(), solution_.data(), begin, end);
                       });
}

template void store_padded<6, 6>(const Dense<6, 6>&, float*);
template PaddedBlocks padded(const BlockRows<3, 6>&);
template PaddedBlocks padded(const BlockRows<6, 3>&);
template PaddedBlocks padded(const BlockRows<6, 6>&);

}  // namespace palpate::fem

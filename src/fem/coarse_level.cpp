#include "fem/coarse_level.hpp"

#include <algorithm>
#include <utility>

#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t node_grain = 256;
constexpr std::size_t coupling_grain = 64;
constexpr std::uint32_t none = 0xffffffffU;
constexpr int cycles = 2;  // Gauss-Seidel cycles in a solve of a level

Dense<3, 3> whole(const SymmetricMatrix3& a) {
  return {a.xx, a.xy, a.xz, a.xy, a.yy, a.yz, a.xz, a.yz, a.zz};
}

}  // namespace

CouplingJacobians::Block& CouplingJacobians::block(std::size_t coupling, std::uint32_t node) {
  const std::size_t first = begin[coupling];
  std::uint32_t& used = count[coupling];
  for (std::size_t k = first; k < first + used; ++k) {
    if (blocks[k].node == node) return blocks[k];
  }
  blocks[first + used] = {.node = node};
  return blocks[first + used++];
}

void CouplingJacobians::reset(std::size_t couplings, const std::vector<std::uint32_t>& limits) {
  resize_with_room(begin, couplings + 1);
  begin[0] = 0;
  for (std::size_t c = 0; c < couplings; ++c) begin[c + 1] = begin[c] + limits[c];
  assign_with_room(count, couplings, 0U);
  resize_with_room(blocks, begin[couplings]);
}

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
  BlockRows<6, 6> off_diagonal;
  for (std::size_t row = 0; row < count; ++row) {
    for (std::uint32_t k = bodies_.begin[row]; k < bodies_.begin[row + 1]; ++k) {
      if (bodies_.columns[k] == row) continue;
      off_diagonal.columns.push_back(bodies_.columns[k]);
      off_diagonal.blocks.push_back(bodies_.blocks[k]);
    }
    off_diagonal.begin.push_back(static_cast<std::uint32_t>(off_diagonal.columns.size()));
  }
  off_diagonal_ = padded(off_diagonal);
  right_side_.resize(count);
  solution_.resize(count);
  residual_.resize(count);
  change_.resize(count);
  places_.assign(parallel::chunk_count(count, node_grain), std::vector<std::uint32_t>(count, none));
}

void CoarseLevel::connect(const BlockRows<6, 6>& transfer, std::size_t next_count) {
  transfer_ = padded(transfer);
  restriction_ = padded(transposed(transfer, next_count));
}

/// Lists the couplings at each node, ascending.
void CoarseLevel::list_couplings() {
  assign_with_room(entry_begin_, size() + 1, 0U);
  const std::size_t couplings = jacobians_.count.size();
  for (std::size_t c = 0; c < couplings; ++c) {
    for (const CouplingJacobians::Block& block : jacobians_.of(c)) ++entry_begin_[block.node + 1];
  }
  for (std::size_t i = 0; i < size(); ++i) entry_begin_[i + 1] += entry_begin_[i];
  resize_with_room(next_entry_, size());
  std::copy(entry_begin_.begin(), entry_begin_.end() - 1, next_entry_.begin());
  resize_with_room(entries_, entry_begin_.back());
  for (std::size_t c = 0; c < couplings; ++c) {
    for (std::uint32_t k = 0; k < jacobians_.count[c]; ++k) {
      const std::uint32_t node = jacobians_.blocks[jacobians_.begin[c] + k].node;
      entries_[next_entry_[node]++] = {static_cast<std::uint32_t>(c), jacobians_.begin[c] + k};
    }
  }
}

/// Calls body(entry, block, place) for each pair of Jacobian blocks of a coupling whose first block is at the
/// node. `place` is the index of the second block's node in the list of nodes found so far.
template <class Body>
void CoarseLevel::for_each_column(std::size_t node, std::vector<std::uint32_t>& place, Body&& body) {
  std::uint32_t found = 0;
  const std::span entries =
      std::span(entries_).subspan(entry_begin_[node], entry_begin_[node + 1] - entry_begin_[node]);
  for (const Entry& entry : entries) {
    for (const CouplingJacobians::Block& block : jacobians_.of(entry.coupling)) {
      if (place[block.node] == none) place[block.node] = found++;
      body(entry, block, place[block.node]);
    }
  }
  for (const Entry& entry : entries) {
    for (const CouplingJacobians::Block& block : jacobians_.of(entry.coupling)) place[block.node] = none;
  }
}

/// Finds the sparsity pattern of the couplings' matrix. The columns of a row are in the order of its
/// couplings.
void CoarseLevel::find_columns(const parallel::Threads& threads) {
  assign_with_room(coupled_.begin, size() + 1, 0U);
  parallel::for_chunks(threads, size(), node_grain, [&](std::size_t begin, std::size_t end, std::size_t c) {
    for (std::size_t node = begin; node < end; ++node) {
      std::uint32_t count = 0;
      for_each_column(node, places_[c],
                      [&](const Entry&, const CouplingJacobians::Block&, std::uint32_t place) {
                        count = std::max(count, place + 1);
                      });
      coupled_.begin[node + 1] = count;
    }
  });
  for (std::size_t i = 0; i < size(); ++i) coupled_.begin[i + 1] += coupled_.begin[i];
  const std::size_t blocks = coupled_.begin.back();
  resize_with_room(coupled_.columns, blocks);
  assign_with_room(coupled_.blocks, blocks, Dense<6, 6>{});
  // Without the diagonal, a row that is not empty has one block less.
  assign_with_room(coupled_off_diagonal_.begin, size() + 1, 0U);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::uint32_t own = coupled_.begin[i + 1] - coupled_.begin[i];
    coupled_off_diagonal_.begin[i + 1] = coupled_off_diagonal_.begin[i] + (own > 0 ? own - 1 : 0);
  }
  const std::size_t off_diagonal = coupled_off_diagonal_.begin.back();
  resize_with_room(coupled_off_diagonal_.columns, off_diagonal);
  if (coupled_off_diagonal_.blocks.capacity() < simd::six_by_six * off_diagonal)
    coupled_off_diagonal_.blocks.reserve(simd::six_by_six * (off_diagonal + off_diagonal / 8 + 16));
  coupled_off_diagonal_.blocks.resize(simd::six_by_six * off_diagonal);
}

void CoarseLevel::add_blocks(const parallel::Threads& threads, const CouplingSystem& couplings) {
  parallel::for_chunks(threads, size(), node_grain, [&](std::size_t begin, std::size_t end, std::size_t c) {
    for (std::size_t node = begin; node < end; ++node) {
      const std::uint32_t first = coupled_.begin[node];
      std::uint32_t last_block = none;
      Dense<3, 6> pushed{};
      for_each_column(node, places_[c],
                      [&](const Entry& entry, const CouplingJacobians::Block& block, std::uint32_t place) {
                        if (entry.block != last_block) {
                          pushed = {};
                          add_product<3, 3, 6>(pushed, whole(couplings.weight(entry.coupling)),
                                               jacobians_.blocks[entry.block].motion);
                          last_block = entry.block;
                        }
                        coupled_.columns[first + place] = block.node;
                        add_transposed_product<6, 3, 6>(coupled_.blocks[first + place], pushed, block.motion);
                      });
      std::uint32_t off_diagonal = coupled_off_diagonal_.begin[node];
      for (std::uint32_t k = first; k < coupled_.begin[node + 1]; ++k) {
        if (coupled_.columns[k] == node) continue;
        coupled_off_diagonal_.columns[off_diagonal] = coupled_.columns[k];
        store_padded<6, 6>(coupled_.blocks[k],
                           coupled_off_diagonal_.blocks.data() + simd::six_by_six * off_diagonal);
        ++off_diagonal;
      }
      const bool coupled = coupled_.begin[node + 1] > first;
      if (coupled || changed_[node] != 0) invert_diagonal(node);
      changed_[node] = coupled ? 1 : 0;
    }
  });
}

void CoarseLevel::invert_diagonal(std::size_t node) {
  Dense<6, 6> block{};
  for (const auto* part : {&bodies_, &coupled_}) {
    for (std::uint32_t k = part->begin[node]; k < part->begin[node + 1]; ++k) {
      if (part->columns[k] != node) continue;
      for (std::size_t e = 0; e < block.size(); ++e) block[e] += part->blocks[k][e];
    }
  }
  store_padded<6, 6>(inverse_semi_definite<6>(block), inverses_.data() + simd::six_by_six * node);
}

void CoarseLevel::coarsen_couplings(const parallel::Threads& threads, CouplingJacobians& next) {
  const std::size_t couplings = jacobians_.count.size();
  assign_with_room(block_limits_, couplings, 0U);
  for (std::size_t c = 0; c < couplings; ++c) {
    for (const CouplingJacobians::Block& block : jacobians_.of(c))
      block_limits_[c] += transfer_.begin[block.node + 1] - transfer_.begin[block.node];
  }
  next.reset(couplings, block_limits_);
  parallel::for_each(threads, couplings, coupling_grain, [&](std::size_t c) {
    for (const CouplingJacobians::Block& block : jacobians_.of(c)) {
      for (std::uint32_t k = transfer_.begin[block.node]; k < transfer_.begin[block.node + 1]; ++k) {
        Dense<3, 6>& motion = next.block(c, transfer_.columns[k]).motion;
        const float* transfer = transfer_.blocks.data() + simd::six_by_six * k;
        Dense<6, 6> turned;  // the transfer block, by rows
        for (std::size_t e = 0; e < 6; ++e) {
          for (std::size_t j = 0; j < 6; ++j) turned[6 * e + j] = static_cast<double>(transfer[8 * j + e]);
        }
        add_product<3, 6, 6>(motion, block.motion, turned);
      }
    }
  });
}

void CoarseLevel::update(const parallel::Threads& threads, const CouplingSystem& couplings,
                         CoarseLevel* next) {
  list_couplings();
  find_columns(threads);
  add_blocks(threads, couplings);
  if (next != nullptr) {
    coarsen_couplings(threads, next->jacobians_);
  } else {
    factor_.update(bodies_, coupled_);
  }
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
  parallel::for_chunks(threads, size(), node_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::residual_above(a, change.data(), residual_.data(), begin, end);
  });
  simd::multiply_six(restriction_.rows(), residual_.data(), next.right_side_.data(), 0, next.size());
  next.solve(threads, below.subspan(1));
  parallel::for_chunks(threads, size(), node_grain, [&](std::size_t begin, std::size_t end, std::size_t) {
    simd::add_six(transfer_.rows(), next.solution_.data(), solution_.data(), begin, end);
  });
}

template PaddedBlocks padded(const BlockRows<3, 6>&);
template PaddedBlocks padded(const BlockRows<6, 3>&);
template PaddedBlocks padded(const BlockRows<6, 6>&);

}  // namespace palpate::fem

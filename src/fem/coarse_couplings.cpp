// The couplings' part of the matrix of a coarse level.
#include <algorithm>
#include <cmath>

#include "fem/coarse_level.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t coupled_node_grain = 64;
constexpr std::size_t coarse_coupling_grain = 64;
constexpr std::uint32_t no_place = 0xffffffffU;

}  // namespace

WeightRows weight_rows(const SymmetricMatrix3& weight) {
  constexpr double rounding = 1e-9;
  std::array<double, 9> rest{weight.xx, weight.xy, weight.xz, weight.xy, weight.yy,
                             weight.yz, weight.xz, weight.yz, weight.zz};
  const double least = rounding * (weight.xx + weight.yy + weight.zz);
  WeightRows result;
  for (std::size_t k = 0; k < 3; ++k) {
    std::size_t pivot = 0;
    for (std::size_t i = 1; i < 3; ++i)
      if (rest[4 * i] > rest[4 * pivot]) pivot = i;
    if (!(rest[4 * pivot] > least)) break;
    const double factor = 1.0 / std::sqrt(rest[4 * pivot]);
    double* row = &result.rows[3 * k];
    for (std::size_t i = 0; i < 3; ++i) row[i] = factor * rest[3 * pivot + i];
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) rest[3 * i + j] -= row[i] * row[j];
    }
    result.count = k == 0 ? 1 : 3;
  }
  return result;
}

std::uint32_t CouplingJacobians::block(std::size_t coupling, std::uint32_t node) {
  const std::uint32_t first = begin[coupling];
  std::uint32_t& used = count[coupling];
  for (std::uint32_t k = first; k < first + used; ++k) {
    if (nodes[k] == node) return k;
  }
  const std::uint32_t added = first + used++;
  nodes[added] = node;
  std::fill_n(motions.begin() + static_cast<std::ptrdiff_t>(simd::three_rows * added),
              simd::row_of_six * rows[coupling], 0.0);
  return added;
}

void CouplingJacobians::reset(std::size_t couplings, const std::vector<std::uint32_t>& limits) {
  resize_with_room(begin, couplings + 1);
  begin[0] = 0;
  for (std::size_t c = 0; c < couplings; ++c) begin[c + 1] = begin[c] + limits[c];
  assign_with_room(count, couplings, 0U);
  resize_with_room(rows, couplings);
  resize_with_room(nodes, begin[couplings]);
  resize_with_room(motions, simd::three_rows * begin[couplings]);
}

const double* CoupledRows::block(std::size_t row, std::uint32_t column) const {
  const auto first = columns.begin() + static_cast<std::ptrdiff_t>(begin[row]);
  const auto last = columns.begin() + static_cast<std::ptrdiff_t>(begin[row + 1]);
  return blocks.data() +
         simd::six_rows * static_cast<std::size_t>(std::lower_bound(first, last, column) - columns.begin());
}

/// Lists the couplings at each node, ascending.
void CoarseLevel::list_couplings() {
  assign_with_room(entry_begin_, size() + 1, 0U);
  const std::size_t couplings = jacobians_.count.size();
  for (std::size_t c = 0; c < couplings; ++c) {
    for (const std::uint32_t node : jacobians_.of(c)) ++entry_begin_[node + 1];
  }
  for (std::size_t i = 0; i < size(); ++i) entry_begin_[i + 1] += entry_begin_[i];
  resize_with_room(next_entry_, size());
  std::copy(entry_begin_.begin(), entry_begin_.end() - 1, next_entry_.begin());
  resize_with_room(entries_, entry_begin_.back());
  for (std::size_t c = 0; c < couplings; ++c) {
    for (std::uint32_t k = jacobians_.begin[c]; k < jacobians_.begin[c] + jacobians_.count[c]; ++k)
      entries_[next_entry_[jacobians_.nodes[k]]++] = {static_cast<std::uint32_t>(c), k};
  }
}

std::span<const CoarseLevel::Entry> CoarseLevel::entries(std::size_t node) const {
  return std::span(entries_).subspan(entry_begin_[node], entry_begin_[node + 1] - entry_begin_[node]);
}

/// Finds the pattern of the couplings' matrix: nodes with a common coupling.
void CoarseLevel::find_columns(const parallel::Threads& threads) {
  assign_with_room(coupled_.begin, size() + 1, 0U);
  chunks_.resize(parallel::chunk_count(size(), coupled_node_grain));
  parallel::for_chunks(
      threads, size(), coupled_node_grain, [&](std::size_t begin, std::size_t end, std::size_t c) {
        Chunk& chunk = chunks_[c];
        chunk.columns.clear();
        if (entry_begin_[begin] == entry_begin_[end]) return;
        if (chunk.places.empty()) chunk.places.assign(size(), no_place);
        for (std::size_t node = begin; node < end; ++node) {
          const std::size_t first = chunk.columns.size();
          for (const Entry& entry : entries(node)) {
            for (const std::uint32_t other : jacobians_.of(entry.coupling)) {
              if (chunk.places[other] != no_place) continue;
              chunk.places[other] = 0;
              chunk.columns.push_back(other);
            }
          }
          const auto own = chunk.columns.begin() + static_cast<std::ptrdiff_t>(first);
          std::sort(own, chunk.columns.end());
          for (std::size_t k = first; k < chunk.columns.size(); ++k)
            chunk.places[chunk.columns[k]] = no_place;
          coupled_.begin[node + 1] = static_cast<std::uint32_t>(chunk.columns.size() - first);
        }
      });
  for (std::size_t i = 0; i < size(); ++i) coupled_.begin[i + 1] += coupled_.begin[i];
  resize_with_room(coupled_.columns, coupled_.begin.back());
  resize_with_room(coupled_.blocks, simd::six_rows * coupled_.columns.size());
  for (std::size_t c = 0; c < chunks_.size(); ++c)
    std::ranges::copy(chunks_[c].columns, coupled_.columns.begin() + coupled_.begin[c * coupled_node_grain]);
}

/// Adds up the blocks on and above the diagonal.
void CoarseLevel::add_blocks(const parallel::Threads& threads) {
  parallel::for_chunks(
      threads, size(), coupled_node_grain, [&](std::size_t begin, std::size_t end, std::size_t c) {
        Chunk& chunk = chunks_[c];
        for (std::size_t node = begin; node < end; ++node) {
          const std::uint32_t first = coupled_.begin[node];
          const std::uint32_t last = coupled_.begin[node + 1];
          if (first == last) continue;
          for (std::uint32_t k = first; k < last; ++k) chunk.places[coupled_.columns[k]] = k;
          chunk.terms.clear();
          for (const Entry& entry : entries(node)) {
            const std::uint32_t start = jacobians_.begin[entry.coupling];
            for (std::uint32_t b = start; b < start + jacobians_.count[entry.coupling]; ++b) {
              const std::uint32_t other = jacobians_.nodes[b];
              if (other >= node)
                chunk.terms.push_back({entry.block, b, chunk.places[other], jacobians_.rows[entry.coupling]});
            }
          }
          for (std::uint32_t k = first; k < last; ++k) chunk.places[coupled_.columns[k]] = no_place;
          double* blocks = coupled_.blocks.data();
          std::fill(blocks + simd::six_rows * first, blocks + simd::six_rows * last, 0.0);
          simd::add_outer_products(jacobians_.motions.data(), chunk.terms.data(), chunk.terms.size(), blocks);
        }
      });
}

/// Stores the blocks off the diagonal for the kernels, and inverts those on it.
void CoarseLevel::store_blocks(const parallel::Threads& threads) {
  assign_with_room(coupled_off_diagonal_.begin, size() + 1, 0U);
  for (std::size_t i = 0; i < size(); ++i) {
    const std::uint32_t own = coupled_.begin[i + 1] - coupled_.begin[i];
    coupled_off_diagonal_.begin[i + 1] = coupled_off_diagonal_.begin[i] + (own > 0 ? own - 1 : 0);
  }
  resize_with_room(coupled_off_diagonal_.columns, coupled_off_diagonal_.begin.back());
  resize_with_room(coupled_off_diagonal_.blocks, simd::six_by_six * coupled_off_diagonal_.begin.back());
  parallel::for_each(threads, size(), coupled_node_grain, [&](std::size_t node) {
    std::uint32_t place = coupled_off_diagonal_.begin[node];
    for (std::uint32_t k = coupled_.begin[node]; k < coupled_.begin[node + 1]; ++k) {
      const std::uint32_t column = coupled_.columns[k];
      if (column == node) continue;
      coupled_off_diagonal_.columns[place] = column;
      float* to = coupled_off_diagonal_.blocks.data() + simd::six_by_six * place++;
      const bool above = column > node;
      const double* block = above ? coupled_.blocks.data() + simd::six_rows * k
                                  : coupled_.block(column, static_cast<std::uint32_t>(node));
      // By columns: the rows of the transposed block.
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < simd::row_of_six; ++j) {
          const double value =
              above ? (j < 6 ? block[simd::row_of_six * j + i] : 0.0) : block[simd::row_of_six * i + j];
          to[simd::row_of_six * i + j] = static_cast<float>(value);
        }
      }
    }
    const bool coupled = coupled_.begin[node + 1] > coupled_.begin[node];
    if (coupled || changed_[node] != 0) invert_diagonal(node);
    changed_[node] = coupled ? 1 : 0;
  });
}

void CoarseLevel::invert_diagonal(std::size_t node) {
  Dense<6, 6> block{};
  for (std::uint32_t k = bodies_.begin[node]; k < bodies_.begin[node + 1]; ++k) {
    if (bodies_.columns[k] == node) block = bodies_.blocks[k];
  }
  if (coupled_.begin[node + 1] > coupled_.begin[node]) {
    const double* more = coupled_.block(node, static_cast<std::uint32_t>(node));
    for (std::size_t e = 0; e < block.size(); ++e) block[e] += more[simd::row_of_six * (e / 6) + e % 6];
  }
  store_padded<6, 6>(inverse_semi_definite<6>(block), inverses_.data() + simd::six_by_six * node);
}

void CoarseLevel::coarsen_couplings(const parallel::Threads& threads, CouplingJacobians& next) {
  const std::size_t couplings = jacobians_.count.size();
  assign_with_room(block_limits_, couplings, 0U);
  for (std::size_t c = 0; c < couplings; ++c) {
    for (const std::uint32_t node : jacobians_.of(c))
      block_limits_[c] += transfer_.begin[node + 1] - transfer_.begin[node];
  }
  next.reset(couplings, block_limits_);
  std::ranges::copy(jacobians_.rows, next.rows.begin());
  // Room in all chunks for the most terms of one, so that only the first steps allocate.
  const std::size_t chunks = parallel::chunk_count(couplings, coarse_coupling_grain);
  if (coupling_chunks_.size() < chunks) coupling_chunks_.resize(chunks + chunks / 8 + 1);
  std::size_t most = 0;
  for (std::size_t first = 0; first < couplings; first += coarse_coupling_grain) {
    most = std::max<std::size_t>(
        most, next.begin[std::min(first + coarse_coupling_grain, couplings)] - next.begin[first]);
  }
  for (Chunk& chunk : coupling_chunks_) make_room(chunk.terms, most);
  parallel::for_chunks(
      threads, couplings, coarse_coupling_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
        std::vector<simd::BlockTerm>& terms = coupling_chunks_[chunk].terms;
        terms.clear();
        for (std::size_t c = begin; c < end; ++c) {
          for (std::uint32_t b = jacobians_.begin[c]; b < jacobians_.begin[c] + jacobians_.count[c]; ++b) {
            const std::uint32_t node = jacobians_.nodes[b];
            for (std::uint32_t k = transfer_.begin[node]; k < transfer_.begin[node + 1]; ++k) {
              terms.push_back(
                  {b, restriction_of_[k], next.block(c, transfer_.columns[k]), jacobians_.rows[c]});
            }
          }
        }
        simd::add_transfers(jacobians_.motions.data(), restriction_.blocks.data(), terms.data(), terms.size(),
                            next.motions.data());
      });
}

void CoarseLevel::update(const parallel::Threads& threads, CoarseLevel* next) {
  list_couplings();
  find_columns(threads);
  add_blocks(threads);
  if (next != nullptr) {
    store_blocks(threads);
    coarsen_couplings(threads, next->jacobians_);
  } else {
    factor_.update(bodies_, coupled_);
  }
}

}  // namespace palpate::fem

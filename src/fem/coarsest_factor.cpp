#include "fem/coarsest_factor.hpp"

#include <algorithm>
#include <numeric>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

std::span<const std::uint32_t> columns(const NodeGraph& rows, Index row) {
  const std::uint32_t first = at(rows.begin, row);
  return rows.columns.subspan(first, at(rows.begin, row + 1) - first);
}

}  // namespace

/// Reverse Cuthill-McKee order (George & Liu 1981, section 4.3): breadth first from a node with few
/// neighbours, then reversed.
void CoarsestFactor::order(const NodeGraph& bodies, const NodeGraph& couplings) {
  const std::size_t count = bodies.begin.size() - 1;
  const auto degree = [&](Index a) { return columns(bodies, a).size() + columns(couplings, a).size(); };
  const auto fewer = [&](Index a, Index b) { return degree(a) != degree(b) ? degree(a) < degree(b) : a < b; };
  degree_order_.resize(count);
  std::iota(degree_order_.begin(), degree_order_.end(), 0);
  std::sort(degree_order_.begin(), degree_order_.end(), fewer);
  row_.assign(count, -1);
  order_.clear();
  order_.reserve(count);
  std::size_t done = 0;
  for (const Index start : degree_order_) {
    if (at(row_, start) >= 0) continue;
    order_.push_back(start);
    at(row_, start) = 0;
    for (; done < order_.size(); ++done) {
      const std::size_t before = order_.size();
      for (const auto* part : {&bodies, &couplings}) {
        for (const std::uint32_t other : columns(*part, order_[done])) {
          if (row_[other] >= 0) continue;
          row_[other] = 0;
          order_.push_back(static_cast<Index>(other));
        }
      }
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(before), order_.end(), fewer);
    }
  }
  std::reverse(order_.begin(), order_.end());
  for (std::size_t row = 0; row < count; ++row) at(row_, order_[row]) = static_cast<Index>(row);
  first_.resize(count);
  for (std::size_t a = 0; a < count; ++a) {
    Index first = row_[a];
    for (const auto* part : {&bodies, &couplings}) {
      for (const std::uint32_t other : columns(*part, static_cast<Index>(a)))
        first = std::min(first, row_[other]);
    }
    at(first_, row_[a]) = first;
  }
}

void CoarsestFactor::update(const BlockRows<6, 6>& bodies, const CoupledRows& couplings) {
  order(graph_of(bodies), {couplings.begin, couplings.columns});
  factor_.reset(first_);
  for (std::size_t a = 0; a < bodies.size(); ++a) {
    for (std::uint32_t k = bodies.begin[a]; k < bodies.begin[a + 1]; ++k) {
      const Index column = row_[bodies.columns[k]];
      if (column > row_[a]) continue;
      factor_.add(row_[a], column, bodies.blocks[k]);
    }
    for (std::uint32_t k = couplings.begin[a]; k < couplings.begin[a + 1]; ++k) {
      if (couplings.columns[k] < a) continue;  // not set
      const Index column = row_[couplings.columns[k]];
      const bool below = column <= row_[a];
      const double* more = couplings.blocks.data() + simd::six_rows * k;
      Block6 block;
      for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j)
          block[6 * i + j] = more[below ? simd::row_of_six * i + j : simd::row_of_six * j + i];
      }
      factor_.add(below ? row_[a] : column, below ? column : row_[a], block);
    }
  }
  factor_.factor();
}

void CoarsestFactor::solve(std::span<const simd::Six> b, std::span<simd::Six> x) {
  resize_with_room(vector_, order_.size());
  for (std::size_t row = 0; row < order_.size(); ++row) {
    for (std::size_t k = 0; k < 6; ++k) vector_[row][k] = static_cast<double>(at(b, order_[row]).values[k]);
    vector_[row][6] = 0.0;
    vector_[row][7] = 0.0;
  }
  factor_.solve(vector_);
  for (std::size_t row = 0; row < order_.size(); ++row) {
    for (std::size_t k = 0; k < 6; ++k) at(x, order_[row]).values[k] = static_cast<float>(vector_[row][k]);
  }
}

}  // namespace palpate::fem

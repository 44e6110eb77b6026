#include "fem/coarsest_factor.hpp"

#include <algorithm>
#include <numeric>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate::fem {
namespace {

std::span<const std::uint32_t> columns(const BlockRows<6, 6>& rows, Index row) {
  const std::uint32_t first = at(rows.begin, row);
  return std::span(rows.columns).subspan(first, at(rows.begin, row + 1) - first);
}

}  // namespace

/// Reverse Cuthill-McKee order (George & Liu 1981, section 4.3): breadth first from a node with few
/// neighbours, then reversed.
void CoarsestFactor::order(const BlockRows<6, 6>& bodies, const BlockRows<6, 6>& couplings) {
  const std::size_t count = bodies.size();
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

void CoarsestFactor::update(const BlockRows<6, 6>& bodies, const BlockRows<6, 6>& couplings) {
  order(bodies, couplings);
  factor_.reset(first_);
  for (const auto* part : {&bodies, &couplings}) {
    for (std::size_t a = 0; a < part->size(); ++a) {
      for (std::uint32_t k = part->begin[a]; k < part->begin[a + 1]; ++k) {
        const Index column = row_[part->columns[k]];
        if (column > row_[a]) continue;
        Block6& block = factor_.block(row_[a], column);
        for (std::size_t e = 0; e < block.size(); ++e) block[e] += part->blocks[k][e];
      }
    }
  }
  factor_.factor();
}

void CoarsestFactor::solve(std::span<const simd::Six> b, std::span<simd::Six> x) {
  resize_with_room(vector_, order_.size());
  for (std::size_t row = 0; row < order_.size(); ++row) {
    for (std::size_t k = 0; k < 6; ++k) vector_[row][k] = static_cast<double>(at(b, order_[row]).values[k]);
  }
  factor_.solve(vector_);
  for (std::size_t row = 0; row < order_.size(); ++row) {
    for (std::size_t k = 0; k < 6; ++k) at(x, order_[row]).values[k] = static_cast<float>(vector_[row][k]);
  }
}

}  // namespace palpate::fem

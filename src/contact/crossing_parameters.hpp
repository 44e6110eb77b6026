#pragma once

#include <cstdint>
#include <span>

#include <palpate/detection.hpp>

#include "contact/border_edge_view.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A border edge and a surface triangle that it meets. Ordered by border edge, then by triangle.
struct EdgeInTriangle {
  Index triangle;
  Index border_edge;
  [[nodiscard]] std::uint64_t key() const {
    return std::uint64_t{static_cast<std::uint32_t>(border_edge)} << 32 |
           static_cast<std::uint32_t>(triangle);
  }
  friend bool operator==(const EdgeInTriangle& a, const EdgeInTriangle& b) { return a.key() == b.key(); }
  friend bool operator<(const EdgeInTriangle& a, const EdgeInTriangle& b) { return a.key() < b.key(); }
};

/// Computes `crossings`, one for each pair in the same order, with its crossing_parameter(). O(crossings),
/// parallel.
void find_parameters(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const BorderEdgeView& border, std::span<const EdgeInTriangle> found,
                     std::span<Crossing> crossings);

}  // namespace palpate

#pragma once

#include <span>

#include <palpate/detection.hpp>

#include "contact/border_edge_view.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A border edge and a surface triangle that it meets.
struct EdgeInTriangle {
  Index border_edge;
  Index triangle;
};

/// Computes `crossings`, one for each pair in the same order, with its crossing_parameter(). O(crossings),
/// parallel.
void find_parameters(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
                     const BorderEdgeView& border, std::span<const EdgeInTriangle> found,
                     std::span<Crossing> crossings);

}  // namespace palpate

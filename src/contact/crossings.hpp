#pragma once

#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "contact/crossing_parameters.hpp"
#include "contact/crossing_query.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// The crossings of a detection, in the order of their border edges.
class Crossings {
 public:
  /// Computes the parameters of the pairs that a query has found. O(pairs + border edges).
  void set(const parallel::Threads& threads, const Bodies& bodies, std::span<const Vec3> positions,
           const BorderEdgeView& border, std::span<const EdgeInTriangle> found);

  /// The crossings, sorted by (border edge, triangle).
  [[nodiscard]] std::span<const Crossing> all() const { return crossings_; }
  /// Swaps all() and this list.
  void swap(std::vector<Crossing>& crossings) { crossings_.swap(crossings); }
  /// Crossings of border edge e: [begin()[e], begin()[e + 1]).
  [[nodiscard]] std::span<const Index> begin() const { return begin_; }

 private:
  std::vector<Index> begin_;
  std::vector<Crossing> crossings_;
};

}  // namespace palpate

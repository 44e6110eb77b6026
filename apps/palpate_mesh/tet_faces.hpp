#pragma once

#include <array>
#include <vector>

#include <palpate/types.hpp>

#include "domain_mesher.hpp"

namespace palpate::app {

/// A face between two tissues, or between a tissue and the outside.
struct InterfaceFace {
  std::array<Index, 3> points{};  ///< ascending
  std::array<Index, 2> tets{};    ///< the tets on both sides, the lower label first; -1 for the outside
  std::array<int, 2> labels{};    ///< ascending, 0: the outside
};

/// All faces whose sides have different labels, in the order of their points. Throws Error if a face has
/// more than two tets. O(n log n).
std::vector<InterfaceFace> interface_faces(const LabelledMesh& mesh);

}  // namespace palpate::app

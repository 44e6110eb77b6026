#pragma once

#include <array>
#include <vector>

#include <palpate/types.hpp>

#include "domain_mesher.hpp"

namespace palpate::app {

/// A face where two tissues meet, or a tissue and the outside.
struct InterfaceFace {
  std::array<Index, 3> points{};  ///< ascending
  std::array<Index, 2> tets{};    ///< that of the lower label first; -1: the outside
  std::array<int, 2> labels{};    ///< ascending, 0: the outside
};

/// All faces whose sides have different labels, in the order of their points. Throws Error where more than
/// two tets share a face. O(n log n).
std::vector<InterfaceFace> interface_faces(const LabelledMesh& mesh);

}  // namespace palpate::app

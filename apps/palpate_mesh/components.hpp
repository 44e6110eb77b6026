#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace palpate::app {

/// Parts of a lattice whose points have the same label and are connected along its edges.
struct Components {
  std::vector<std::int32_t> of;       ///< (n_points) part of each point, from 0; -1 if its label is 0
  std::vector<std::size_t> sizes;     ///< (n_components), points
  std::vector<std::uint16_t> labels;  ///< (n_components)
};

/// Computes the components of (size[2], size[1], size[0]) labels, in the order of their first points.
/// O(points).
Components components_of(const std::array<int, 3>& size, std::span<const std::uint16_t> labels);

}  // namespace palpate::app

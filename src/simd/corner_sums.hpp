#pragma once

#include <cstddef>
#include <cstdint>

#include "simd/padded.hpp"

namespace palpate::simd {

/// sums[places[c]] += values[4 c .. 4 c + 3] for the four corners c of each element. Takes every sixteenth
/// element, one after the other, because neighbours share points and consecutive additions to a point would
/// wait for each other. The order is fixed: the same bits on every target.
void add_corners(const double* values, const std::uint16_t* places, std::size_t elements, Padded3* sums);

}  // namespace palpate::simd

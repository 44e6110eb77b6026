#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace palpate::simd {

/// The numbers that are not above a limit.
struct ReachedPairs {
  std::size_t size = 0;
  float least;  ///< of those above the limit
};

/// Finds the pairs whose distances are not above a limit, and writes their places. There must be room for 16
/// more.
/// \param least  an upper bound of the result's
ReachedPairs find_reached(std::span<const float> distances, float limit, float least, std::int32_t* places);

}  // namespace palpate::simd

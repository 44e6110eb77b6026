#pragma once

#include <cstddef>

namespace palpate::fem {

// Chunks of parallel loops. Sums are cut by them too, so results depend on these numbers.
inline constexpr std::size_t slice_grain = 16;     ///< slices of rows
inline constexpr std::size_t point_grain = 256;    ///< points
inline constexpr std::size_t contact_grain = 256;  ///< couplings of contacts
inline constexpr std::size_t domain_grain = 128;   ///< smoothing domains

}  // namespace palpate::fem

#pragma once

#include <cstddef>

namespace palpate {

/// Points beyond which memory is asked for ahead of its use: fewer stay in the cache of a core anyway.
inline constexpr std::size_t most_in_cache = 16384;

/// Asks for a line of memory that the next phase needs; changes nothing else.
inline void prefetch([[maybe_unused]] const void* address) {
#if defined(__GNUC__)
  __builtin_prefetch(address);
#endif
}

}  // namespace palpate

#include "grid/footprints.hpp"

#include <limits>
#include <string>

#include <palpate/error.hpp>

namespace palpate {

void require_countable(std::size_t entries) {
  if (entries > std::numeric_limits<std::uint32_t>::max() - 1) {
    throw Error("grid", "", std::to_string(entries) + " entries (cells covered by primitives)",
                "at most 4294967294; use a larger cell size");
  }
}

}  // namespace palpate

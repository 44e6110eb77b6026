#pragma once

#include <cstddef>
#include <string>

#include <palpate/error.hpp>

namespace palpate::fem {

/// Throws Error if an array that is passed to a Dynamics has a wrong length.
/// \param per  what each value belongs to, such as "point"
inline void check_length(const char* name, std::size_t found, std::size_t expected, const char* per) {
  if (found == expected) return;
  throw Error("dynamics", name, std::to_string(found) + " values",
              std::to_string(expected) + " values, one per " + per);
}

}  // namespace palpate::fem

#pragma once

#include <string>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

namespace palpate {

/// Whether a point is in no tet. Mesh files may have such points; they do not move.
inline bool is_unused(const Bodies& bodies, Index point) {
  return bodies.point_tets()[point].empty();
}

/// Throws Error if a point is in no tet: nothing can act on tissue through it.
inline void check_used(const Bodies& bodies, Index point, const char* source, const std::string& where) {
  if (is_unused(bodies, point))
    throw Error(source, where, "point " + std::to_string(point) + ", which is in no tet", "points of tets");
}

}  // namespace palpate

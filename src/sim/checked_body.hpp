#pragma once

#include <string>

#include <palpate/error.hpp>
#include <palpate/mesh.hpp>

namespace palpate {

/// The body with this number. Throws an Error of outcomes where there is none.
inline const Body& checked_body(const Bodies& bodies, Index body) {
  if (body >= 0 && body < bodies.body_count()) return at(bodies.bodies(), body);
  throw Error("outcomes", "body", std::to_string(body), "less than " + std::to_string(bodies.body_count()));
}

}  // namespace palpate

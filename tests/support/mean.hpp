#pragma once

#include <span>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate::test {

/// Mean of the values (n_points x 3) of a body's points: its centre, its velocity.
inline Vec3 mean_of_body(const Bodies& bodies, Index body, std::span<const Vec3> values) {
  const Range points = at(bodies.bodies(), body).points;
  Vec3 sum;
  for (Index p = points.begin; p < points.end; ++p) sum += at(values, p);
  return (1.0 / points.size()) * sum;
}

}  // namespace palpate::test

#pragma once

#include <algorithm>
#include <set>
#include <span>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "support/rational.hpp"

namespace palpate::test {

/// Whether tissue inside out brought a point into a tet, by the definition and in rational arithmetic.
inline bool rational_fold(const Bodies& bodies, std::span<const Vec3> x, Index point, const Tet& tet) {
  std::set<Index> near{point};
  for (const Edge& edge : bodies.edges()) {
    if (edge[0] == point) near.insert(edge[1]);
    if (edge[1] == point) near.insert(edge[0]);
  }
  return std::any_of(bodies.tets().begin(), bodies.tets().end(), [&](const Tet& t) {
    const auto in = [&](const auto& set) {
      return std::any_of(t.begin(), t.end(),
                         [&](Index c) { return std::find(set.begin(), set.end(), c) != set.end(); });
    };
    if (!in(tet) || !in(near)) return false;
    const RationalVec o = rational(at(x, t[0]));
    const auto side = [&](std::size_t i) { return minus(rational(at(x, t[i])), o); };
    return determinant(side(1), side(2), side(3)) <= 0;
  });
}

}  // namespace palpate::test

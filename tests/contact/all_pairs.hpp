#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/layers.hpp"
#include "contact/pair_filter.hpp"
#include "geometry/box.hpp"

namespace palpate::test {

using Pairs = std::vector<std::pair<Index, Index>>;
using InTet = bool (*)(const Vec3&, const Vec3&, const Vec3&, const Vec3&, const Vec3&);

struct AllPairs {
  Pairs pairs;  ///< (point, tet), sorted
  std::size_t folded = 0;
};

/// Every point against every tet.
inline AllPairs all_pairs(const Bodies& bodies, std::span<const Vec3> x, const PairFilter& may_touch,
                          InTet in_tet) {
  AllPairs result;
  for (Index p = 0; p < static_cast<Index>(x.size()); ++p) {
    for (Index t = 0; t < static_cast<Index>(bodies.tets().size()); ++t) {
      const Tet& tet = at(bodies.tets(), t);
      const Index own = at(bodies.body_of_point(), p);
      const Index body = bodies.body_of(tet);
      if (!box_of(x, tet).contains(at(x, p)) || !may_touch(own, body, p, tet)) continue;
      if (!in_tet(at(x, p), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3]))) continue;
      if (own == body && is_fold(bodies, x, p, t)) {
        ++result.folded;
      } else {
        result.pairs.emplace_back(p, t);
      }
    }
  }
  return result;
}

}  // namespace palpate::test

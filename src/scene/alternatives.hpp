#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace palpate::scene_format {

/// For each of three keys, whether it is given. Exactly one must be.
using Alternatives = std::array<std::pair<std::string, bool>, 3>;
template <class Visitor>
void require_one(Visitor& v, const Alternatives& keys) {
  const auto count = std::ranges::count(keys, true, &Alternatives::value_type::second);
  const auto given = std::ranges::find(keys.rbegin(), keys.rend(), true, &Alternatives::value_type::second);
  v.rule(count == 1, given == keys.rend() ? keys[0].first : given->first,
         count == 0 ? "nothing" : "more than one of these keys",
         "exactly one of '" + keys[0].first + "', '" + keys[1].first + "' and '" + keys[2].first + "'");
}

/// The keys that select points, of which exactly one is given.
template <class Visitor, class Points>
void describe_points(Visitor& v, Points& points) {
  v.one_of(points, {"box", "sphere", "points", "near"});
}

}  // namespace palpate::scene_format

#pragma once

namespace palpate {

/// How words are sorted by key (issue 3: becomes palpate::Sort).
enum class SortMethod {
  radix,       ///< least significant digit first
  counting,    ///< by counting over the domain; where that is sparse, radix
  comparison,  ///< parallel sort by comparisons, which gains from sorted input
  repair,      ///< last frame's order with the movers put right
  adaptive,    ///< repair while few references move, else radix, or counting where C is wanted and the domain
               ///< dense
};

}  // namespace palpate

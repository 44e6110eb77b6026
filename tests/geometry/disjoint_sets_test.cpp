// Disjoint sets against the plain way: a label for each number, replaced everywhere at a join.

#include "geometry/disjoint_sets.hpp"

#include <algorithm>
#include <cstddef>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <vector>

namespace palpate {
namespace {

TEST(DisjointSets, TheLowestNumberStandsForASetWhateverTheOrderOfJoins) {
  constexpr Index count = 60;
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<Index> number(0, count - 1);
    DisjointSets sets(count);
    std::vector<Index> labels(count);
    std::iota(labels.begin(), labels.end(), 0);
    for (unsigned join = 0; join < seed; ++join) {
      const Index i = number(random);
      const Index j = number(random);
      sets.join(i, j);
      const Index a = labels[static_cast<std::size_t>(i)];
      const Index b = labels[static_cast<std::size_t>(j)];
      std::ranges::replace(labels, std::max(a, b), std::min(a, b));
    }
    for (Index i = 0; i < count; ++i) EXPECT_EQ(sets.find(i), labels[static_cast<std::size_t>(i)]);
  }
}

}  // namespace
}  // namespace palpate

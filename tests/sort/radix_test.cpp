// Oracle: std::stable_sort on the same digits.
#include "sort/radix.hpp"

#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "sort/rows.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

std::vector<std::uint64_t> words(std::size_t n, const std::function<std::uint64_t(std::size_t)>& key) {
  std::vector<std::uint64_t> w(n);
  for (std::size_t i = 0; i < n; ++i) w[i] = (key(i) << 32) | i;
  return w;
}

class RadixSortOf : public ::testing::TestWithParam<int> {};

TEST_P(RadixSortOf, AdversarialKeys) {
  const parallel::Threads threads(GetParam());
  test::Random random(7);
  RadixSort sort;
  // Around the block of 2^14 words, and empty or almost empty input.
  for (const std::size_t n : {0U, 1U, 2U, 3U, 255U, 257U, 16383U, 16384U, 16385U, 70000U}) {
    const std::vector<std::vector<std::uint64_t>> inputs{
        words(n, [](std::size_t) { return 5U; }),                            // all equal
        words(n, [](std::size_t i) { return i; }),                           // all distinct, in order
        words(n, [n](std::size_t i) { return n - i; }),                      // reversed
        words(n, [n](std::size_t i) { return i == n / 2 ? 0 : i; }),         // one mover
        words(n, [](std::size_t i) { return i % 2; }),                       // > 2^14 of each
        words(n, [&](std::size_t) { return random.word() & 0xFFFFFFFFU; }),  // random, all 32 bits
        words(n,
              [&](std::size_t) { return random.word() & 0xFF00FFU; }),  // a digit that is the same everywhere
    };
    for (std::size_t k = 0; k < inputs.size(); ++k) {
      std::vector<std::uint64_t> expected = inputs[k];
      std::stable_sort(expected.begin(), expected.end(),
                       [](std::uint64_t a, std::uint64_t b) { return (a >> 32) < (b >> 32); });
      std::vector<std::uint64_t> sorted = inputs[k];
      const std::uint64_t largest = n == 0 ? 0 : *std::max_element(sorted.begin(), sorted.end());
      sort(threads, sorted, 32, largest);
      ASSERT_EQ(sorted, expected) << "input " << k << " of " << n << " words";
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Threads, RadixSortOf, ::testing::Values(1, 2, 3, 5),
                         [](const auto& p) { return std::to_string(p.param); });

TEST(SortIntoRows, IsStableAndFillsEmptyRows) {
  const std::vector<std::pair<int, char>> items{{3, 'a'}, {0, 'b'}, {3, 'c'}, {0, 'd'}, {5, 'e'}};
  std::vector<Index> begin;
  std::vector<std::pair<int, char>> sorted;
  sort_into_rows<std::pair<int, char>>(
      items, 7, [](const auto& i) { return i.first; }, begin, sorted);
  EXPECT_EQ(begin, (std::vector<Index>{0, 2, 2, 2, 4, 4, 5, 5}));
  EXPECT_EQ(sorted, (std::vector<std::pair<int, char>>{{0, 'b'}, {0, 'd'}, {3, 'a'}, {3, 'c'}, {5, 'e'}}));
}

}  // namespace
}  // namespace palpate

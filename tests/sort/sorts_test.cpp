// Oracle: std::stable_sort by key of words in order of their references.
#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "sort/comparison.hpp"
#include "sort/counting.hpp"
#include "sort/radix.hpp"
#include "sort/word.hpp"
#include "support/random.hpp"
#include "support/sort_oracle.hpp"

namespace palpate {
namespace {

using Keys = std::vector<std::uint32_t>;

/// Hard key sets of `n` references for sorts, each with its key count.
std::vector<std::pair<Keys, std::uint32_t>> adversarial_keys(std::uint32_t n, test::Random& random) {
  const auto fill = [n](const std::function<std::uint32_t(std::uint32_t)>& key) {
    Keys keys(n);
    for (std::uint32_t i = 0; i < n; ++i) keys[i] = key(i);
    return keys;
  };
  const auto random_below = [&random](std::uint32_t bound) {
    return static_cast<std::uint32_t>(random.word() % bound);
  };
  return {
      {fill([](std::uint32_t) { return 0U; }), 1},                              // the only cell
      {fill([](std::uint32_t) { return 5U; }), 9},                              // all equal
      {fill([](std::uint32_t i) { return i; }), n + 1},                         // all distinct, in order
      {fill([n](std::uint32_t i) { return n - i; }), n + 1},                    // reversed
      {fill([n](std::uint32_t i) { return i == n / 2 ? 0 : i; }), n + 1},       // one mover, back
      {fill([n](std::uint32_t i) { return i == n / 2 ? n : i; }), n + 1},       // one mover, forth
      {fill([](std::uint32_t i) { return i % 2; }), 2},                         // half of all in a cell
      {fill([](std::uint32_t i) { return i ^ 1U; }), n + 2},                    // neighbours swapped
      {fill([&](std::uint32_t) { return random_below(2048); }), 2048},          // one digit of 11 bits
      {fill([&](std::uint32_t) { return random_below(2049); }), 2049},          // just two
      {fill([&](std::uint32_t) { return random_below(1U << 17); }), 1U << 17},  // ranges
      {fill([&](std::uint32_t) { return random_below(1U << 17) & 0x1F00FU; }), 1U << 17},  // equal digits
      {fill([&](std::uint32_t i) { return i % 3 == 0 ? no_key : random_below(70000); }),
       70000},                                              // some have no key
      {fill([](std::uint32_t) { return no_key; }), 70000},  // all have no key
  };
}

// Around the block of 2^14 and 2^15 words, around widths of vectors, and almost empty input.
constexpr std::uint32_t sizes[] = {0,  1,  2,   3,   7,     8,     9,     15,    16,    17,    31,    32,
                                   33, 63, 255, 257, 16383, 16384, 16385, 32767, 32768, 32769, 140000};

class SortOf : public ::testing::TestWithParam<int> {
 protected:
  const parallel::Threads threads_{GetParam()};
  test::Random random_{7};
};

TEST_P(SortOf, RadixFromKeys) {
  RadixSort sort;
  std::vector<std::uint64_t> words;
  for (const std::uint32_t n : sizes) {
    int set = 0;
    for (const auto& [keys, key_count] : adversarial_keys(n, random_)) {
      sort.from_keys(threads_, keys, key_count, words);
      ASSERT_EQ(words, test::stably_sorted(keys)) << "set " << set << " of " << n;
      ++set;
    }
  }
}

TEST_P(SortOf, RadixOfAll32Bits) {
  RadixSort sort;
  Keys keys(50000);
  for (auto& key : keys) key = static_cast<std::uint32_t>(random_.word() % no_key);
  std::vector<std::uint64_t> words;
  sort.from_keys(threads_, keys, no_key, words);
  EXPECT_EQ(words, test::stably_sorted(keys));
}

TEST_P(SortOf, Counting) {
  CountingSort sort;
  std::vector<std::uint64_t> words;
  std::vector<std::uint32_t> cell_begin;
  for (const std::uint32_t n : sizes) {
    int set = 0;
    for (const auto& [keys, key_count] : adversarial_keys(n, random_)) {
      sort(threads_, keys, key_count, words, cell_begin);
      ASSERT_EQ(words, test::stably_sorted(keys)) << "set " << set << " of " << n;
      ASSERT_EQ(cell_begin, test::cell_starts(words, key_count)) << "set " << set << " of " << n;
      ++set;
    }
  }
}

TEST_P(SortOf, CountingOfADomainWithManyRanges) {
  CountingSort sort;
  Keys keys(100000);
  for (auto& key : keys) key = static_cast<std::uint32_t>(random_.word() % 20000003U);
  std::vector<std::uint64_t> words;
  std::vector<std::uint32_t> cell_begin;
  sort(threads_, keys, 20000003, words, cell_begin);
  EXPECT_EQ(words, test::stably_sorted(keys));
  EXPECT_EQ(cell_begin, test::cell_starts(words, 20000003));
}

TEST_P(SortOf, IndexCells) {
  std::vector<std::uint32_t> cell_begin;
  for (const std::uint32_t n : sizes) {
    for (const auto& [keys, key_count] : adversarial_keys(n, random_)) {
      const auto words = test::stably_sorted(keys);
      index_cells(threads_, words, key_count, cell_begin);
      ASSERT_EQ(cell_begin, test::cell_starts(words, key_count)) << n;
    }
  }
}

TEST_P(SortOf, Comparison) {
  ComparisonSort sort;
  for (const std::uint32_t n : sizes) {
    int set = 0;
    for (const auto& [keys, key_count] : adversarial_keys(n, random_)) {
      std::vector<std::uint64_t> words;
      for (std::uint32_t i = 0; i < n; ++i)
        if (keys[i] != no_key) words.push_back(make_word(keys[i], i));
      sort(threads_, words);
      ASSERT_EQ(words, test::stably_sorted(keys)) << "set " << set << " of " << n;
      ++set;
    }
  }
}

TEST_P(SortOf, ComparisonOfPredominantlySortedWords) {
  ComparisonSort sort;
  for (const double fraction : {0.0, 0.001, 0.02, 0.1, 0.24, 0.26, 1.0}) {
    std::vector<std::uint64_t> words(100003);
    for (std::size_t i = 0; i < words.size(); ++i)
      words[i] = random_.chance(fraction) ? random_.word() : std::uint64_t{i} << 40;
    auto expected = words;
    std::stable_sort(expected.begin(), expected.end());
    sort(threads_, words);
    ASSERT_EQ(words, expected) << fraction;
  }
}

INSTANTIATE_TEST_SUITE_P(Threads, SortOf, ::testing::Values(1, 2, 3, 5),
                         [](const auto& p) { return std::to_string(p.param); });

}  // namespace
}  // namespace palpate

// Oracle: std::stable_sort of each frame on its own.
#include "sort/point_sort.hpp"

#include <array>
#include <gtest/gtest.h>
#include <string>

#include "sort/word.hpp"
#include "support/random.hpp"
#include "support/sort_oracle.hpp"

namespace palpate {
namespace {

using Keys = std::vector<std::uint32_t>;

/// Moves a fraction of the keys: to a near cell, anywhere, or in and out of existence.
void move_keys(Keys& keys, std::uint32_t key_count, double fraction, test::Random& random) {
  for (auto& key : keys) {
    if (key != no_key && key >= key_count) key = key_count - 1;
    if (!random.chance(fraction)) continue;
    const int kind = random.integer(0, 9);
    if (kind == 0)
      key = no_key;
    else if (kind < 4 || key == no_key)
      key = static_cast<std::uint32_t>(random.word() % key_count);
    else
      key = (key + static_cast<std::uint32_t>(random.integer(-3, 3)) + key_count) % key_count;
  }
}

std::size_t count_movers(const Keys& before, const Keys& now) {
  std::size_t movers = 0;
  for (std::size_t i = 0; i < std::max(before.size(), now.size()); ++i) {
    const std::uint32_t old_key = i < before.size() ? before[i] : no_key;
    const std::uint32_t new_key = i < now.size() ? now[i] : no_key;
    movers += old_key != new_key ? 1 : 0;
  }
  return movers;
}

class PointSortOf : public ::testing::TestWithParam<std::tuple<Sort, int>> {};

// Small frames, in which edge cases are frequent: 0 to 100 % movers, changing counts of keys and references.
TEST_P(PointSortOf, EqualsAFullSortAfterEachOf1000Frames) {
  const auto [method, thread_count] = GetParam();
  const parallel::Threads threads(thread_count);
  const std::uint64_t seed = 11;
  test::Random random(seed);
  PointSort sort(method);
  Keys keys;
  Keys before;
  std::vector<std::uint64_t> words;
  std::vector<std::uint32_t> cell_begin;
  std::uint32_t key_count = 1;
  for (int frame = 0; frame < 1000; ++frame) {
    if (random.chance(0.1)) keys.resize(static_cast<std::size_t>(random.integer(0, 600)), no_key);
    if (random.chance(0.1)) key_count = static_cast<std::uint32_t>(random.integer(1, 3000));
    constexpr std::array fractions{0.0, 0.002, 0.02, 0.1, 0.5, 1.0};
    move_keys(keys, key_count, fractions.at(static_cast<std::size_t>(random.integer(0, 5))), random);
    const bool with_cells = random.chance(0.8);
    const auto result = sort.update(threads, keys, key_count, words, with_cells ? &cell_begin : nullptr);
    ASSERT_EQ(words, test::stably_sorted(keys)) << "frame " << frame << ", seed " << seed;
    ASSERT_EQ(result.movers, count_movers(before, keys)) << "frame " << frame << ", seed " << seed;
    if (with_cells) {
      ASSERT_EQ(cell_begin, test::cell_starts(words, key_count)) << "frame " << frame << ", seed " << seed;
    }
    before = keys;
  }
}

// Frames of several blocks: chunks, segments and their borders.
TEST_P(PointSortOf, EqualsAFullSortOnLargeFrames) {
  const auto [method, thread_count] = GetParam();
  const parallel::Threads threads(thread_count);
  test::Random random(12);
  PointSort sort(method);
  std::vector<std::uint64_t> words;
  std::vector<std::uint32_t> cell_begin;
  for (const std::uint32_t n : {65535U, 65536U, 65537U, 200000U}) {
    // Many keys for each word, few, and one cell that holds more than 2^16.
    for (const std::uint32_t key_count : {3 * n, n / 4, 2U}) {
      Keys keys(n, no_key);
      for (const double fraction : {1.0, 0.02, 0.0, 0.1, 0.00002, 1.0, 0.3}) {
        move_keys(keys, key_count, fraction, random);
        sort.update(threads, keys, key_count, words, &cell_begin);
        ASSERT_EQ(words, test::stably_sorted(keys))
            << n << " references, " << key_count << " keys, " << fraction;
        ASSERT_EQ(cell_begin, test::cell_starts(words, key_count))
            << n << ", " << key_count << ", " << fraction;
      }
    }
  }
}

TEST_P(PointSortOf, StartsAnewWhereTheWordsAreNotItsOwn) {
  const auto [method, thread_count] = GetParam();
  const parallel::Threads threads(thread_count);
  PointSort sort(method);
  const Keys keys{3, 1, 2, 1};
  std::vector<std::uint64_t> words{1, 2, 3, 4, 5};
  EXPECT_EQ(sort.update(threads, keys, 4, words).movers, 4U);
  EXPECT_EQ(words, test::stably_sorted(keys));
  words.clear();
  EXPECT_EQ(sort.update(threads, keys, 4, words).movers, 4U);
  EXPECT_EQ(words, test::stably_sorted(keys));
  EXPECT_EQ(sort.update(threads, keys, 4, words).movers, 0U);
  EXPECT_EQ(words, test::stably_sorted(keys));
}

std::string name_of(const ::testing::TestParamInfo<std::tuple<Sort, int>>& parameters) {
  constexpr std::array names{"radix", "counting", "comparison", "repair", "adaptive"};
  return names.at(static_cast<std::size_t>(std::get<0>(parameters.param))) + std::string("_") +
         std::to_string(std::get<1>(parameters.param));
}

INSTANTIATE_TEST_SUITE_P(Methods, PointSortOf,
                         ::testing::Combine(::testing::Values(Sort::radix, Sort::counting, Sort::comparison,
                                                              Sort::repair, Sort::adaptive),
                                            ::testing::Values(1, 2, 3, 5)),
                         name_of);

/// The methods used in a sequence of frames with these fractions of movers.
std::vector<Sort> methods_used(std::uint32_t key_count, bool wants_cells,
                               const std::vector<double>& fractions) {
  const parallel::Threads threads(1);
  test::Random random(13);
  PointSort sort(Sort::adaptive);
  Keys keys(1000, 0);
  std::vector<std::uint64_t> words;
  std::vector<std::uint32_t> cell_begin;
  std::vector<Sort> used;
  for (const double fraction : fractions) {
    // Exactly that fraction, each to another cell.
    for (std::size_t i = 0; i < static_cast<std::size_t>(1000 * fraction); ++i)
      keys[i] = (keys[i] + 1) % key_count;
    used.push_back(sort.update(threads, keys, key_count, words, wants_cells ? &cell_begin : nullptr).used);
  }
  return used;
}

TEST(AdaptiveSort, UsesAFullSortForManyMoversAndRepairForFew) {
  constexpr double between = (SortSwitch::lower_fraction + SortSwitch::upper_fraction) / 2;
  const std::vector<double> fractions{0.0, 0.02, between, 0.9, between, 0.02, between, 0.0};
  const auto expected = [](Sort full) {
    constexpr auto repair = Sort::repair;
    // The first frame is all movers; between the thresholds the method stays.
    return std::vector{full, repair, repair, full, full, repair, repair, repair};
  };
  EXPECT_EQ(methods_used(1000, true, fractions), expected(Sort::counting));
  EXPECT_EQ(methods_used(1000, false, fractions), expected(Sort::radix));
  EXPECT_EQ(methods_used(1000000, true, fractions), expected(Sort::radix));
}

}  // namespace
}  // namespace palpate

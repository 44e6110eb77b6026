// The kernels on every SIMD target of this processor, and in plain C++, against loops of the standard
// library.
#include <algorithm>
#include <cstdint>
#include <gtest/gtest.h>
#include <set>
#include <vector>

#include "simd/key_changes.hpp"
#include "simd/merge_events.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

using ListChanges = decltype(&simd::list_changes);
using MergeEvents = decltype(&simd::merge_events);

void check_changes(ListChanges list_changes, const char* target) {
  test::Random random(3);
  for (std::size_t n = 0; n < 200; ++n) {
    for (const double fraction : {0.0, 0.05, 0.5, 1.0}) {
      std::vector<std::uint32_t> before(n);
      for (auto& key : before) key = static_cast<std::uint32_t>(random.word());
      std::vector<std::uint32_t> now = before;
      std::vector<std::uint32_t> expected;
      for (std::size_t i = 0; i < n; ++i) {
        if (!random.chance(fraction)) continue;
        now[i] ^= std::uint32_t{1} << random.integer(0, 31);
        expected.push_back(static_cast<std::uint32_t>(1000 + i));
      }
      std::vector<std::uint32_t> changed(n + 1, 77);
      const std::size_t count = list_changes(before, now, 1000, changed.data());
      ASSERT_EQ(changed[n], 77U) << target << ": wrote beyond its room";
      changed.resize(count);
      ASSERT_EQ(changed, expected) << target << ", " << n;
    }
  }
}

void check_merge(MergeEvents merge_events, const char* target) {
  test::Random random(4);
  for (int round = 0; round < 3000; ++round) {
    std::set<std::uint64_t> words;
    const int size = random.integer(0, 100);
    // Words up to 2^64 - 1 but for the bit of the mark: comparisons must be unsigned.
    const auto draw = [&] { return (random.word() << random.integer(0, 40)) & ~simd::removal; };
    while (static_cast<int>(words.size()) < size) words.insert(draw());
    std::set<std::uint64_t> expected = words;
    std::vector<std::uint64_t> events;
    const double fraction = random.uniform(0.0, 1.0);
    for (const std::uint64_t word : words) {
      if (!random.chance(fraction)) continue;
      expected.erase(word);
      events.push_back(word | simd::removal);
    }
    for (int i = random.integer(0, 40); i > 0; --i) {
      const std::uint64_t word = draw();
      if (!words.contains(word) && expected.insert(word).second) events.push_back(word);
    }
    std::sort(events.begin(), events.end(),
              [](auto a, auto b) { return (a & ~simd::removal) < (b & ~simd::removal); });
    const std::vector<std::uint64_t> in(words.begin(), words.end());
    std::vector<std::uint64_t> merged(expected.size() + 1, 77);
    merge_events(in, events, std::span(merged).first(expected.size()));
    ASSERT_EQ(merged.back(), 77U) << target << ": wrote beyond its room";
    merged.pop_back();
    ASSERT_EQ(merged, std::vector<std::uint64_t>(expected.begin(), expected.end()))
        << target << ", " << round;
  }
}

TEST(SimdKernels, ListChanges) {
  int targets = 0;
  test::for_each_simd_target([&](const char* target) {
    ++targets;
    check_changes(simd::list_changes, target);
  });
  EXPECT_GT(targets, 0);
  check_changes(simd::scalar::list_changes, "scalar twin");
}

TEST(SimdKernels, MergeEvents) {
  test::for_each_simd_target([](const char* target) { check_merge(simd::merge_events, target); });
  check_merge(simd::scalar::merge_events, "scalar twin");
}

}  // namespace
}  // namespace palpate

#include <gtest/gtest.h>

#include "sort/point_sort.hpp"
#include "support/count_allocations.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

// Some references have no key, others move. Few and many movers alternate, so that `adaptive` uses all its
// methods.
TEST(PointSortAllocations, ASteadyFrameMakesNone) {
  for (const Sort method : {Sort::radix, Sort::counting, Sort::comparison, Sort::repair, Sort::adaptive}) {
    for (const int thread_count : {1, 2}) {
      const parallel::Threads threads(thread_count);
      test::Random random(9);
      constexpr std::uint32_t key_count = 40000;
      std::vector<std::uint32_t> keys(100000, 5);
      std::vector<std::uint64_t> words;
      std::vector<std::uint32_t> cell_begin;
      PointSort sort(method);
      long before = 0;
      for (int frame = 0; frame < 30; ++frame) {
        for (auto& key : keys) {
          if (!random.chance(frame % 4 == 0 ? 0.8 : 0.02)) continue;
          key = random.chance(0.1) ? 0xFFFFFFFFU : static_cast<std::uint32_t>(random.word() % key_count);
        }
        if (frame == 10) before = allocations;
        sort.update(threads, keys, key_count, words, &cell_begin);
      }
      ASSERT_GT(before, 0) << "allocations are not counted";
      EXPECT_EQ(allocations - before, 0)
          << "method " << static_cast<int>(method) << ", " << thread_count << " threads";
    }
  }
}

}  // namespace
}  // namespace palpate

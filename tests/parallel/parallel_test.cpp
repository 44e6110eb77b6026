// Oracles: each chunk exactly once; sums in the order documented in parallel.hpp; the plain loop.
#include "parallel/parallel.hpp"

#include <atomic>
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <palpate/error.hpp>

namespace palpate::parallel {
namespace {

TEST(Threads, CountIsWhatWasAskedFor) {
  EXPECT_EQ(Threads(3).count(), 3);
  EXPECT_EQ(Threads(0).count(), static_cast<int>(std::max(1U, std::thread::hardware_concurrency())));
}

TEST(Threads, RefusesCountsOutOfRange) {
  EXPECT_THROW(Threads(-1), Error);
  EXPECT_THROW(Threads(1000000), Error);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers need more address space
/// Uses as many threads as the system gives: here no further ones, since there is no memory for their stacks.
TEST(Threads, GoesOnWithFewerWhereTheSystemGivesNoMore) {
  const pid_t child = ::fork();
  if (child == 0) {
    rlimit limit{};
    limit.rlim_cur = limit.rlim_max = 1;  // no address space: mapping a stack fails
    ::setrlimit(RLIMIT_AS, &limit);
    const Threads threads(4);
    std::atomic<int> calls{0};
    threads.run(10, [&](std::size_t) { calls.fetch_add(1); });
    ::_exit(threads.count() == 1 && calls.load() == 10 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
}
#endif

TEST(Threads, EachChunkOnceInManyLoopsOfAllSizes) {
  for (const int count : {1, 2, 3, 8}) {
    const Threads threads(count);
    for (int round = 0; round < 2000; ++round) {
      const std::size_t chunks = static_cast<std::size_t>(round) % 37;
      std::vector<std::atomic<int>> calls(chunks);
      threads.run(chunks, [&](std::size_t c) { calls[c].fetch_add(1); });
      for (std::size_t c = 0; c < chunks; ++c)
        ASSERT_EQ(calls[c].load(), 1) << "chunk " << c << " of " << chunks;
    }
  }
}

/// A thread that ends a loop of many chunks may find the next one, of few, under way.
TEST(Threads, LoopsOfManyChunksAndOfFewTakeTurns) {
  for (const int count : {3, 16}) {
    const Threads threads(count);
    std::atomic<std::size_t> calls{0};
    for (int round = 0; round < 20000; ++round) {
      for (const std::size_t chunks : {40U, 2U, 3U}) {
        calls = 0;
        threads.run(chunks, [&](std::size_t) {
          volatile int work = 0;
          for (int i = 0; i < 300; ++i) work = work + 1;
          calls.fetch_add(1);
        });
        ASSERT_EQ(calls.load(), chunks) << "round " << round;
      }
    }
  }
}

TEST(Threads, AllTakePartWhereTheWorkIsLong) {
  const Threads threads(4);
  std::atomic<int> inside{0};
  std::atomic<int> most{0};
  threads.run(4, [&](std::size_t) {
    const int now = inside.fetch_add(1) + 1;
    int seen = most.load();
    while (seen < now && !most.compare_exchange_weak(seen, now)) {
    }
    for (int i = 0; i < 2000 && most.load() < 4; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  EXPECT_EQ(most.load(), 4);
}

/// Each thread begins with its own part of the chunks. A chunk in the middle waits for all others.
TEST(Threads, OthersDoTheChunksOfAThreadThatIsHeldUp) {
  for (const int count : {2, 3, 5}) {
    const Threads threads(count);
    for (const std::size_t held : {std::size_t{0}, std::size_t{8}, std::size_t{15}}) {
      std::atomic<int> done{0};
      bool in_time = false;
      threads.run(16, [&](std::size_t chunk) {
        for (int i = 0; chunk == held && i < 10000 && done.load() < 15; ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (chunk == held) in_time = done.load() == 15;
        done.fetch_add(1);
      });
      EXPECT_TRUE(in_time) << count << " threads, chunk " << held;
    }
  }
}

TEST(Threads, SharedByTwoCallersAtOnceDoAllChunks) {
  const Threads threads(3);
  std::atomic<long> total{0};
  const auto caller = [&] {
    for (int round = 0; round < 500; ++round) {
      const Threads copy = threads;
      copy.run(20, [&](std::size_t c) { total.fetch_add(static_cast<long>(c)); });
    }
  };
  std::thread other(caller);
  caller();
  other.join();
  EXPECT_EQ(total.load(), 2L * 500 * 190);
}

TEST(ForChunks, CoversAllItemsAndHandsOutTheChunkNumber) {
  const Threads threads(3);
  for (const std::size_t items : {0U, 1U, 9U, 10U, 11U, 1000U}) {
    std::vector<std::size_t> chunk_of(items, 99999);
    for_chunks(threads, items, 10, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      for (std::size_t i = begin; i < end; ++i) chunk_of[i] = chunk;
    });
    for (std::size_t i = 0; i < items; ++i) EXPECT_EQ(chunk_of[i], i / 10);
  }
}

TEST(ForChunks, RethrowsTheExceptionOfTheLowestChunkAndGoesOnWorking) {
  for (const int count : {1, 4}) {
    const Threads threads(count);
    for (int round = 0; round < 100; ++round) {
      try {
        for_chunks(threads, 100, 1, [&](std::size_t begin, std::size_t, std::size_t) {
          if (begin == 13 || begin == 77) throw std::runtime_error(std::to_string(begin));
        });
        FAIL();
      } catch (const std::runtime_error& e) {
        EXPECT_STREQ(e.what(), "13");
      }
    }
  }
}

TEST(Sum, HasTheBitsOfChunkSumsInOrder) {
  const std::size_t items = 5 * sum_grain + 17;
  const auto value = [](std::size_t i) { return std::sin(static_cast<double>(i)) * 1e10; };
  double expected = 0.0;
  for (std::size_t begin = 0; begin < items; begin += sum_grain) {
    double chunk = 0.0;
    for (std::size_t i = begin; i < std::min(items, begin + sum_grain); ++i) chunk += value(i);
    expected += chunk;
  }
  std::vector<double> partial;
  for (const int count : {1, 2, 3, 7}) EXPECT_EQ(sum(Threads(count), items, partial, value), expected);
  EXPECT_EQ(sum(Threads(2), 0, partial, value), 0.0);
}

TEST(ChunkedList, JoinsInTheOrderOfTheItems) {
  std::vector<std::size_t> joined;
  ChunkedList<std::size_t> list;
  for (const int count : {1, 3}) {
    const Threads threads(count);
    for (const std::size_t items : {1000U, 10U, 0U, 500U, 100000U}) {
      list.fill(threads, items, 7, [](std::size_t begin, std::size_t end, std::vector<std::size_t>& own) {
        for (std::size_t i = begin; i < end; ++i) {
          if (i % 3 == 0) own.push_back(i);
        }
      });
      list.join(threads, joined);
      const std::size_t found = (items + 2) / 3;
      ASSERT_EQ(joined.size(), found);
      for (std::size_t i = 0; i < found; ++i) ASSERT_EQ(joined[i], 3 * i);
      list.append(threads, joined, chunk_count(items, 7));
      ASSERT_EQ(joined.size(), 2 * found);
      for (std::size_t i = 0; i < 2 * found; ++i) ASSERT_EQ(joined[i], 3 * (i % found));
    }
  }
}

}  // namespace
}  // namespace palpate::parallel

// What is read from callgrind's output, by hand-written output with known sums.
#include "speed/callgrind.hpp"

#include <gtest/gtest.h>
#include <string>

#include <palpate/error.hpp>

namespace palpate::test {
namespace {

using bench::CallgrindCounts;

/// Two calls of a loop with eight chunks each, 100 instructions a chunk; one loop with a single chunk; 400
/// instructions elsewhere.
const std::string profile = R"(events: Ir
fn=palpate::work()
7 300
cfn=void palpate::parallel::for_chunks<A>(T const&, unsigned long, A&&)
calls=2 0
8 1640
cfn=void palpate::parallel::for_chunks<B>(T const&, unsigned long, B&&)
calls=1 0
9 260
fn=void palpate::parallel::for_chunks<A>(T const&, unsigned long, A&&)
3 40
cfn=void palpate::parallel::for_chunks<A>(T const&, unsigned long, A&&)::{lambda(unsigned long)#1}::operator()(unsigned long) const
calls=16 0
4 1600
fn=void palpate::parallel::for_chunks<B>(T const&, unsigned long, B&&)
3 60
cfn=void palpate::parallel::for_chunks<B>(T const&, unsigned long, B&&)::{lambda(unsigned long)#1}::operator()(unsigned long) const [clone .isra.0]
calls=1 0
4 200
totals: 2200
)";

TEST(Callgrind, ChunksAreApartFromWhatIsInNoLoop) {
  const CallgrindCounts counts = bench::parse_callgrind(profile, "profile");
  EXPECT_EQ(counts.instructions, 2200.0);
  ASSERT_EQ(counts.loops.size(), 2U);
  EXPECT_EQ(counts.loops[0].calls, 2.0);
  EXPECT_EQ(counts.loops[0].chunks, 16.0);
  EXPECT_EQ(counts.loops[0].instructions, 1600.0);
  EXPECT_EQ(counts.loops[1].instructions, 200.0);
}

TEST(Callgrind, TheLongestChainHasTheChunksOfTheBusiestThread) {
  const CallgrindCounts counts = bench::parse_callgrind(profile, "profile");
  EXPECT_EQ(bench::longest_chain(counts, 1), 2200.0);
  EXPECT_EQ(bench::longest_chain(counts, 2), 600.0 + 800.0);
  EXPECT_EQ(bench::longest_chain(counts, 3), 600.0 + 600.0) << "one thread has three of eight chunks";
  EXPECT_EQ(bench::longest_chain(counts, 8), 600.0 + 200.0);
  EXPECT_EQ(bench::longest_chain(counts, 1e9), 800.0) << "no chunk is divided";
}

TEST(Callgrind, TextWithoutTotalsIsRefused) {
  EXPECT_THROW(bench::parse_callgrind("events: Ir\n", "profile"), Error);
}

}  // namespace
}  // namespace palpate::test

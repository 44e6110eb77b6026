#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::bench {

/// A parallel loop (parallel::for_chunks), all its calls together.
struct LoopCount {
  double calls = 0.0;
  double chunks = 0.0;        ///< of all calls
  double instructions = 0.0;  ///< of all chunks
};

/// What callgrind has counted of a kernel, in one thread.
struct CallgrindCounts {
  double units = 0.0;         ///< of work
  double instructions = 0.0;  ///< all
  std::vector<LoopCount> loops;
};

/// Runs a kernel of palpate-bench-kernels. Throws Error if it or valgrind fails.
CallgrindCounts count_with_callgrind(std::string_view kernel, int cells, int frames);

/// Counts of callgrind's output file with names that are not compressed. A loop is a function whose name
/// has "parallel::for_chunks", its chunks are calls of the function within it. Throws Error on text without
/// totals.
/// \param name  of the file, for the error
CallgrindCounts parse_callgrind(const std::string& text, const std::string& name);

/// Instructions on the longest chain with so many threads, if all chunks of a loop cost alike: what is in no
/// loop, and of each call of a loop the chunks of the thread that has most of them.
double longest_chain(const CallgrindCounts& counts, double threads);

/// Why instructions cannot be counted on this machine; empty: they can.
std::string why_not_counted();

}  // namespace palpate::bench

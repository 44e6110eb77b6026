// Sorts of words by key from frame to frame, compared with std::sort and memcpy of the same bytes. All start
// from the keys of a frame, and so pay for making their words. One thread.
//
// Every competitor first sorts one full turn of the frames, and each result is compared with the expected
// one; so is the last result of the measured turns. A wrong result is an error of the benchmark, and the
// program ends with 1.
#include <algorithm>
#include <atomic>
#include <benchmark/benchmark.h>
#include <cstring>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "io/machine.hpp"
#include "measure/sort_frames.hpp"
#include "measure/sorters.hpp"

namespace palpate::bench {
namespace {

using measure::Competitor;
using measure::Movers;
using measure::Sorter;
using measure::SortFrames;

std::atomic<bool> wrong{false};

/// The frames of one size and movers: made when the first competitor asks, kept for those that follow.
const SortFrames& frames_of(std::size_t entries, Movers movers) {
  static SortFrames frames;
  static std::pair<std::size_t, Movers> made{0, Movers::still};
  if (made != std::pair{entries, movers}) {
    frames = {};
    frames = measure::make_frames(entries, movers);
    made = {entries, movers};
  }
  return frames;
}

void run(benchmark::State& state, const Competitor& competitor, std::size_t entries, Movers movers) {
  const std::string name = competitor.name + "/" + std::to_string(entries) + "/" + measure::name_of(movers);
  const SortFrames& frames = frames_of(entries, movers);
  const Sorter sort = competitor.make();
  const auto check = [&](std::size_t step) {
    const bool copies = competitor.name == "memcpy";
    const std::size_t frame = frames.frame_at(step);
    const std::vector<std::uint64_t>& words = sort(frames, frame);
    if (words == frames.sorted[copies ? 0 : frame]) return true;
    wrong = true;
    state.SkipWithError("the result is not the sorted array");
    return false;
  };
  std::size_t step = 0;
  // The whole turn once, four steps in the repetitions, until no memory is asked for any more; with 10M
  // entries std::sort would take half a minute.
  static std::set<std::string> checked_before;
  const bool whole = entries <= 5000000 && checked_before.insert(name).second;
  const std::size_t checked = whole ? frames.keys.size() : 4;
  for (; step < checked; ++step)
    if (!check(step)) return;
  for (auto _ : state) {
    benchmark::DoNotOptimize(sort(frames, frames.frame_at(step)).data());
    benchmark::ClobberMemory();
    ++step;
  }
  check(step);
  state.counters["entries"] = static_cast<double>(entries);
}

void register_all() {
  for (const std::size_t entries :
       {std::size_t{8192}, std::size_t{131072}, std::size_t{1} << 20, std::size_t{10000000}}) {
    for (const Movers movers :
         {Movers::still, Movers::near_2, Movers::near_10, Movers::near_100, Movers::random_100}) {
      for (const Competitor& competitor : measure::competitors()) {
        const std::string name =
            competitor.name + "/" + std::to_string(entries) + "/" + measure::name_of(movers);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          run(state, competitor, entries, movers);
        })->Unit(benchmark::kMicrosecond);
      }
    }
  }
}

}  // namespace
}  // namespace palpate::bench

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const palpate::io::Machine machine = palpate::io::describe_machine();
  benchmark::AddCustomContext("cpu", machine.cpu);
  benchmark::AddCustomContext("cores", std::to_string(machine.cores));
  benchmark::AddCustomContext("compiler", machine.compiler + ", " + machine.build_type);
  benchmark::AddCustomContext("commit", machine.commit);
  palpate::bench::register_all();
  benchmark::RunSpecifiedBenchmarks();
  return palpate::bench::wrong ? 1 : 0;
}

// Sorts of words by key from frame to frame, beside std::sort and memcpy of the same bytes. All start from
// the keys of a frame, and so pay for making their words. One thread.
//
// Every competitor first sorts one full turn of the frames, and each result is compared with the expected
// one; so is the last result of the measured turns. A wrong result is an error of the benchmark, and
// the program ends with 1.
#include <algorithm>
#include <atomic>
#include <benchmark/benchmark.h>
#include <cstring>
#include <functional>
#include <memory>
#include <set>
#include <string>

#include "io/machine.hpp"
#include "sort/point_sort.hpp"
#include "sort/word.hpp"
#include "sort_frames.hpp"

namespace palpate::bench {
namespace {

std::atomic<bool> wrong{false};

/// Sorts the next frame in its own memory; returns the words.
using Sorter = std::function<const std::vector<std::uint64_t>&(const SortFrames&, std::size_t frame)>;

struct Competitor {
  std::string name;
  std::function<Sorter()> make;
};

Sorter point_sort(Sort method, bool with_cells) {
  struct State {
    PointSort sort;
    parallel::Threads threads{1};
    std::vector<std::uint64_t> words;
    std::vector<std::uint32_t> cell_begin;
  };
  auto state = std::make_shared<State>();
  state->sort = PointSort(method);
  return
      [state, with_cells](const SortFrames& frames, std::size_t frame) -> const std::vector<std::uint64_t>& {
        state->sort.update(state->threads, frames.keys[frame], frames.key_count, state->words,
                           with_cells ? &state->cell_begin : nullptr);
        return state->words;
      };
}

/// std::sort, from last frame's order with the new keys (as the paper does) or from the order of references.
Sorter std_sort(bool from_last_order) {
  auto words = std::make_shared<std::vector<std::uint64_t>>();
  return [words, from_last_order](const SortFrames& frames,
                                  std::size_t frame) -> const std::vector<std::uint64_t>& {
    const std::vector<std::uint32_t>& keys = frames.keys[frame];
    if (from_last_order && words->size() == keys.size()) {
      for (std::uint64_t& word : *words) word = make_word(keys[word_reference(word)], word_reference(word));
    } else {
      words->resize(keys.size());
      for (std::size_t i = 0; i < keys.size(); ++i)
        (*words)[i] = make_word(keys[i], static_cast<std::uint32_t>(i));
    }
    std::sort(words->begin(), words->end());
    return *words;
  };
}

/// The bound: copies the expected result.
Sorter copy() {
  auto words = std::make_shared<std::vector<std::uint64_t>>();
  return [words](const SortFrames& frames, std::size_t) -> const std::vector<std::uint64_t>& {
    // Of the first frame each time, so that no more memory is touched than by a sort in place.
    const std::vector<std::uint64_t>& from = frames.sorted.front();
    words->resize(from.size());
    std::memcpy(words->data(), from.data(), from.size() * sizeof(std::uint64_t));
    return *words;
  };
}

std::vector<Competitor> competitors() {
  return {
      {"memcpy", copy},
      {"std_sort_last_order", [] { return std_sort(true); }},
      {"std_sort_reference_order", [] { return std_sort(false); }},
      {"comparison", [] { return point_sort(Sort::comparison, false); }},
      {"radix", [] { return point_sort(Sort::radix, false); }},
      {"counting", [] { return point_sort(Sort::counting, false); }},
      {"repair", [] { return point_sort(Sort::repair, false); }},
      {"adaptive", [] { return point_sort(Sort::adaptive, false); }},
      {"radix_with_C", [] { return point_sort(Sort::radix, true); }},
      {"counting_with_C", [] { return point_sort(Sort::counting, true); }},
      {"repair_with_C", [] { return point_sort(Sort::repair, true); }},
  };
}

/// The frames of one size and motion: made when the first competitor asks, kept for those that follow.
const SortFrames& frames_of(std::size_t entries, Motion motion) {
  static SortFrames frames;
  static std::pair<std::size_t, Motion> made{0, Motion::still};
  if (made != std::pair{entries, motion}) {
    frames = {};
    frames = make_frames(entries, motion);
    made = {entries, motion};
  }
  return frames;
}

void run(benchmark::State& state, const Competitor& competitor, std::size_t entries, Motion motion) {
  const std::string name = competitor.name + "/" + std::to_string(entries) + "/" + name_of(motion);
  const SortFrames& frames = frames_of(entries, motion);
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
    for (const Motion motion :
         {Motion::still, Motion::near_2, Motion::near_10, Motion::near_100, Motion::random_100}) {
      for (const Competitor& competitor : competitors()) {
        const std::string name = competitor.name + "/" + std::to_string(entries) + "/" + name_of(motion);
        benchmark::RegisterBenchmark(name.c_str(), [=](benchmark::State& state) {
          run(state, competitor, entries, motion);
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

#include <fmt/format.h>
#include <map>
#include <span>

#include <palpate/error.hpp>

#include "measure/paper.hpp"
#include "measure/sorters.hpp"
#include "sim/state_hash.hpp"
#include "stopwatch.hpp"

namespace palpate::measure {
namespace {

constexpr std::size_t entries = 128000;

/// Times of sorting a frame, ms, over some passes through the frames; the sorters alternate. Throws Error
/// if one does not sort.
std::map<std::string, std::vector<double>> times_of(const SortFrames& frames, int rounds) {
  const std::vector<Competitor> all = competitors();
  std::vector<Sorter> sorters;
  sorters.reserve(all.size());
  for (const Competitor& competitor : all) sorters.push_back(competitor.make());
  std::map<std::string, std::vector<double>> times;
  const std::size_t steps = static_cast<std::size_t>(rounds) * frames.steps();
  for (std::size_t step = 0; step < steps; ++step) {
    const std::size_t frame = frames.frame_at(step);
    for (std::size_t round = 0; round < all.size(); ++round) {
      const std::size_t s = (step + round) % all.size();
      Stopwatch watch;
      const std::vector<std::uint64_t>& words = sorters[s](frames, frame);
      const double seconds = watch.lap();
      if (all[s].name != "memcpy" && words != frames.sorted[frame])
        throw Error("benchmark", all[s].name, "words out of order", "sorted words");
      if (step == 0) continue;  // the first frame has no previous order
      times[all[s].name].push_back(1e3 * seconds);
    }
  }
  return times;
}

}  // namespace

Section sort_timings(const PaperEffort& effort) {
  Section section{
      .id = "sorting",
      .title = "Sorting 128,000 entries",
      .paper =
          "On four cores radix sort takes 14 ms whatever changes, the STL sort less than 6 ms at 10 % "
          "changed keys and 3 ms at 2 %; random keys cost about the same with both. So the STL sort is "
          "always to be preferred.",
      .ours =
          "One thread, smallest times. `std_sort_last_order` starts from last frame's order, as the paper "
          "does. `comparison` is our parallel sort of that kind. Every result is compared with "
          "std::sort's.",
      .table = {{"sort; ms by changed keys, %"}, {}}};
  const std::vector<std::pair<Movers, std::string>> motions{
      {Movers::still, "0"},    {Movers::near_2, "2"},     {Movers::near_10, "10"},
      {Movers::near_50, "50"}, {Movers::near_100, "100"}, {Movers::random_100, "random"}};
  std::map<std::string, std::map<std::string, double>> all;
  std::uint64_t hash = fnv1a({});
  Chart chart{
      .title = "Sorting 128,000 entries", .x_label = "changed keys, %", .y_label = "ms", .series = {}};
  for (const auto& [movers, name] : motions) {
    const SortFrames frames = make_frames(entries, movers);
    hash = fnv1a(std::as_bytes(std::span(frames.sorted.back())), hash);
    for (auto& [sort, times] : times_of(frames, effort.rounds)) {
      const bool reference = sort == "memcpy" || sort.starts_with("std_sort");
      section.measures.push_back(measure_of(name + " %, " + sort, std::move(times), reference));
      all[name][sort] = section.measures.back().least;
    }
    section.table.columns.push_back(name);
  }
  for (const Competitor& competitor : competitors()) {
    auto& row = section.table.rows.emplace_back();
    row.emplace_back(competitor.name);
    for (const auto& [movers, name] : motions) row.emplace_back(all[name][competitor.name]);
  }
  section.result_hash = hash_text(hash);
  for (const char* sort : {"std_sort_last_order", "comparison", "radix", "repair", "adaptive"}) {
    Series series{sort, {}, {}};
    for (const char* percent : {"0", "2", "10", "50", "100"}) {
      series.x.push_back(std::stod(percent));
      series.y.push_back(all[percent][sort]);
    }
    chart.series.push_back(std::move(series));
  }
  section.charts.push_back(std::move(chart));
  const auto ratio = [&](const char* percent) {
    return all[percent]["std_sort_last_order"] / all[percent]["radix"];
  };
  section.verdict = ratio("2") < 1.0 && ratio("10") < 1.0 ? Verdict::agrees : Verdict::differs;
  section.why = fmt::format(
      "std::sort takes {:.1f} (2 %), {:.1f} (10 %) and {:.1f} (random) times as long as our radix sort: "
      "today's radix sort needs few digits. The sort that gains from the last order is the repair sort: "
      "{:.2f} ms at 2 %, {:.2f} ms at 10 %; the adaptive switch uses it up to 14 % changed keys "
      "(docs/structures.md)",
      ratio("2"), ratio("10"), ratio("random"), all["2"]["repair"], all["10"]["repair"]);
  return section;
}

}  // namespace palpate::measure

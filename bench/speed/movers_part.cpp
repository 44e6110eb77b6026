// Sorts entries of which 2 % change cell: our repair compared with std::sort from the last frame's order, and
// a copy of the same bytes.
#include <array>
#include <map>
#include <string>

#include <palpate/error.hpp>

#include "measure/sorters.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"
#include "timing.hpp"

namespace palpate::bench {
namespace {

constexpr std::size_t entries = 131072;
constexpr std::array<const char*, 3> names{"memcpy", "std_sort_last_order", "repair"};

Json measure_sorts(std::size_t steps) {
  const measure::SortFrames frames = measure::make_frames(entries, measure::Movers::near_2);
  std::map<std::string, measure::Sorter> sorters;
  for (const measure::Competitor& competitor : measure::competitors()) {
    for (const char* name : names)
      if (competitor.name == name) sorters[name] = competitor.make();
  }
  std::map<std::string, std::vector<double>> times;
  // The first step has no order of a last frame, the next ones let memory grow.
  constexpr std::size_t warm_up = 4;
  for (std::size_t step = 0; step < warm_up + steps; ++step) {
    const std::size_t frame = frames.frame_at(step);
    for (const char* name : names) {
      const std::vector<std::uint64_t>* words = nullptr;
      const double time = milliseconds([&] { words = &sorters.at(name)(frames, frame); });
      if (name != names[0] && *words != frames.sorted[frame])
        throw Error("benchmark", name, "words out of order", "sorted words");
      if (step >= warm_up) times[name].push_back(time);
    }
  }
  Json result{{"name", "2 % near"}, {"entries", entries}, {"frames", steps}};
  for (const auto& [name, values] : times) result[name + "_ms"] = median(values);
  return result;
}

}  // namespace

Part movers_part(const SpeedEffort& effort) {
  const auto frames = static_cast<std::size_t>(effort.frames_or(160));
  return {"movers", {{"2 % of 128k entries", 0.0, [frames] { return measure_sorts(frames); }}}, movers_rows};
}

}  // namespace palpate::bench

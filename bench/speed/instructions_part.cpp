// Instructions of the hot kernels, counted by valgrind's callgrind: a change that costs some is seen on the
// busiest machine. And what part of a detection and of a step threads can share.
#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "measure/query_scenes.hpp"
#include "speed/callgrind.hpp"
#include "speed/kernels.hpp"
#include "speed/part.hpp"
#include "speed/rows.hpp"

namespace palpate::bench {
namespace {

constexpr int instruction_frames = 4;
constexpr double usual_tets = 1e4;
constexpr std::array counted_threads{2, 4, 8, 16, 32};

/// Of all instructions, what is not on the longest chain with any number of threads; and by how much threads
/// are faster, if chunks cost alike, waiting costs nothing and instructions take the same time.
Json parallel_part_of(const CallgrindCounts& counts) {
  const double all = counts.instructions;
  Json faster;
  for (const int threads : counted_threads)
    faster[std::to_string(threads)] = all / longest_chain(counts, threads);
  const double chain = longest_chain(counts, std::numeric_limits<double>::infinity());
  return {{"longest_chain", chain}, {"share", 1.0 - chain / all}, {"speed_up", faster}};
}

Json count(const Kernel& kernel, int cells, int frames_asked_for) {
  const int frames = std::max(1, frames_asked_for / kernel.frames_for_one);
  const CallgrindCounts counts = count_with_callgrind(kernel.name, cells, frames);
  return {{"name", kernel.name},
          {"unit", kernel.unit},
          {"cells", cells},
          {"frames", frames},
          {"units", counts.units},
          {"instructions", counts.instructions},
          {"per_unit", counts.instructions / counts.units},
          {"parallel", parallel_part_of(counts)}};
}

}  // namespace

Part instructions_part(const SpeedEffort& effort) {
  const int cells = std::max(1, measure::stacking_cells(std::min(effort.most_tets, usual_tets)));
  const int frames = effort.frames_or(instruction_frames);
  Part part{"instructions", {}, instructions_rows};
  for (const Kernel& kernel : kernels)
    part.cases.push_back({std::string(kernel.name), 0.0, [=] { return count(kernel, cells, frames); }});
  return part;
}

}  // namespace palpate::bench

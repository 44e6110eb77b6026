#include "phase_times.hpp"

#include <algorithm>
#include <numeric>

namespace palpate::app {

void PhaseTimes::add(const StepMetrics& m, double step_seconds) {
  const DetectionTimes& t = m.detection_seconds;
  const std::array<double, names.size()> times{t.grid,  t.contacts,       t.border_edges,   t.crossings,
                                               t.depth, m.forces_seconds, m.solver_seconds, step_seconds};
  for (std::size_t phase = 0; phase < names.size(); ++phase) seconds_[phase].push_back(times[phase]);
}

double PhaseTimes::mean(std::size_t phase) const {
  const std::vector<double>& times = seconds_[phase];
  if (times.empty()) return 0.0;
  return std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size());
}

double PhaseTimes::median(std::size_t phase) const {
  std::vector<double> times = seconds_[phase];
  if (times.empty()) return 0.0;
  std::ranges::sort(times);
  const std::size_t middle = times.size() / 2;
  return times.size() % 2 == 1 ? times[middle] : 0.5 * (times[middle - 1] + times[middle]);
}

}  // namespace palpate::app

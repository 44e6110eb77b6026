#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include <palpate/simulation.hpp>

namespace palpate::app {

/// Wall time of each phase of each step.
class PhaseTimes {
 public:
  /// The phases in the order in which they run; the last is the whole step.
  static constexpr std::array<std::string_view, 8> names{"grid",  "contacts", "border edges", "crossings",
                                                         "depth", "forces",   "solver",       "step"};

  void add(const StepMetrics& metrics, double step_seconds);
  [[nodiscard]] std::size_t steps() const { return seconds_[0].size(); }

  /// Mean and median over the steps, s; 0 where there was no step. O(steps).
  [[nodiscard]] double mean(std::size_t phase) const;
  [[nodiscard]] double median(std::size_t phase) const;

 private:
  std::array<std::vector<double>, names.size()> seconds_;
};

}  // namespace palpate::app

#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include <palpate/simulation.hpp>

#include "status_line.hpp"

namespace palpate::app {

/// Prints the progress of a run on stderr: on a terminal one line that is rewritten in place, otherwise a
/// line every few seconds and one at the end.
class Progress {
 public:
  /// \param first_step  the step at which the run begins
  /// \param most_steps  the step at which the run ends at the latest
  Progress(std::int64_t first_step, std::int64_t most_steps, bool quiet);
  /// Call after each step.
  void update(const StepMetrics& metrics);
  /// Call after the last step.
  void finish(const StepMetrics& metrics);

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] std::string line(const StepMetrics& metrics, std::size_t width) const;

  std::int64_t first_step_;
  std::int64_t most_steps_;
  StatusLine status_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace palpate::app

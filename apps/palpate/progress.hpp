#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include <palpate/simulation.hpp>

namespace palpate::app {

/// Tells on stderr how far a run is: on a terminal one line that is rewritten in place, else a line every few
/// seconds and one at the end.
class Progress {
 public:
  /// \param first_step  at which it begins
  /// \param most_steps  the step at which the run ends at the latest
  Progress(std::int64_t first_step, std::int64_t most_steps, bool quiet);
  /// Leaves the cursor at the start of a fresh line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// After each step.
  void update(const StepMetrics& metrics);
  /// After the last.
  void finish(const StepMetrics& metrics);

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] std::string line(const StepMetrics& metrics, std::size_t width) const;
  void show(const StepMetrics& metrics);

  std::int64_t first_step_;
  std::int64_t most_steps_;
  bool quiet_;
  bool on_terminal_;
  bool line_open_ = false;
  Clock::time_point start_ = Clock::now();
  Clock::time_point shown_ = start_;
};

}  // namespace palpate::app

#pragma once

#include <chrono>

namespace palpate {

/// Measures the phases of a step, one after the other.
class Stopwatch {
 public:
  /// Seconds since construction or the last lap().
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - last_).count();
  }
  /// seconds(), and restarts.
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace palpate

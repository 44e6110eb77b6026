#pragma once

#include <chrono>

namespace palpate {

/// A time after which results are no longer refined.
class Deadline {
 public:
  using Clock = std::chrono::steady_clock;

  /// Without a limit.
  Deadline() = default;
  explicit Deadline(Clock::time_point end) : end_(end) {}
  static Deadline after_seconds(double seconds) {
    return Deadline(Clock::now() +
                    std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)));
  }
  [[nodiscard]] bool exists() const { return end_ != Clock::time_point::max(); }
  /// Reads the clock only if there is a deadline. May be called from any thread.
  [[nodiscard]] bool passed() const { return exists() && Clock::now() >= end_; }

 private:
  Clock::time_point end_ = Clock::time_point::max();
};

}  // namespace palpate

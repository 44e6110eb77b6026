#pragma once

#include "stopwatch.hpp"
#include "timing.hpp"

namespace palpate::bench {

/// Seconds since it was made: processor time where one thread works, so that a busy machine hardly shows;
/// else those of the clock on the wall.
class Clock {
 public:
  explicit Clock(int threads) : one_thread_(threads == 1) {}
  [[nodiscard]] double seconds() const {
    return one_thread_ ? processor_time() - processor_ : wall_.seconds();
  }
  [[nodiscard]] double wall_seconds() const { return wall_.seconds(); }

 private:
  bool one_thread_;
  double processor_ = processor_time();
  Stopwatch wall_;
};

}  // namespace palpate::bench

#pragma once

namespace palpate::app {

/// While it lives, the first SIGINT or SIGTERM asks for an end instead of killing; the next one kills at
/// once.
///
/// A signal that was ignored from outside (nohup, a job in the background) stays ignored. One at a time.
class InterruptFlag {
 public:
  InterruptFlag();
  ~InterruptFlag();
  InterruptFlag(const InterruptFlag&) = delete;
  InterruptFlag& operator=(const InterruptFlag&) = delete;

  [[nodiscard]] bool requested() const;
};

}  // namespace palpate::app

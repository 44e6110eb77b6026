#pragma once

namespace palpate::app {

/// While it lives, the first SIGINT, SIGTERM or SIGHUP (a terminal or ssh that goes away) asks for an end
/// instead of killing; the next SIGINT or SIGTERM kills at once. After one of them SIGHUP stays ignored.
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

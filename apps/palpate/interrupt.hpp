#pragma once

namespace palpate::app {

/// While it lives, the first SIGINT, SIGTERM or SIGHUP (a terminal or ssh that goes away) sets a flag instead
/// of ending the process. Signals within the next quarter of a second belong to the same request. A later
/// SIGINT or SIGTERM ends the process at once, also after the flag is gone. After the first signal SIGHUP is
/// ignored.
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

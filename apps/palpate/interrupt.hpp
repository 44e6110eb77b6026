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

/// While it lives, SIGINT, SIGTERM or SIGHUP ends the process at once, with exit_failed and a line on
/// standard error: for work that has nothing to undo and may take long. Not while an InterruptFlag lives.
class InterruptEnd {
 public:
  /// \param line  with its end of line; must outlive the object
  explicit InterruptEnd(const char* line);
  ~InterruptEnd();
  InterruptEnd(const InterruptEnd&) = delete;
  InterruptEnd& operator=(const InterruptEnd&) = delete;
};

}  // namespace palpate::app

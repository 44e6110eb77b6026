#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

namespace palpate::app {

/// Prints progress on stderr: on a terminal one line that is rewritten in place, else a line every few
/// seconds.
class StatusLine {
 public:
  /// Makes the line, no longer than so many columns.
  using Text = std::function<std::string(std::size_t width)>;

  explicit StatusLine(bool quiet);
  /// Leaves the cursor at the start of a fresh line.
  ~StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// Shows the line if the last one is old enough.
  void update(const Text& text);
  /// Shows it now.
  void show(const Text& text);
  /// Takes the line off the terminal again.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  bool quiet_;
  bool on_terminal_;
  bool line_open_ = false;
  Clock::time_point shown_ = Clock::now();
};

}  // namespace palpate::app

#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

namespace palpate::app {

/// Prints progress on stderr: on a terminal one line that is rewritten in place, otherwise a line every few
/// seconds.
class StatusLine {
 public:
  /// Sets the text of the line, of at most `width` columns.
  using Text = std::function<std::string(std::size_t width)>;

  explicit StatusLine(bool quiet);
  /// Moves the cursor to the start of a new line.
  ~StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  /// Shows the line if the one shown is old enough.
  void update(const Text& text);
  /// Shows the line now.
  void show(const Text& text);
  /// Removes the line from the terminal.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  bool quiet_;
  bool on_terminal_;
  bool line_open_ = false;
  Clock::time_point shown_ = Clock::now();
};

}  // namespace palpate::app

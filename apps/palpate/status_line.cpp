#include "status_line.hpp"

#include <cstdio>
#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "messages.hpp"

namespace palpate::app {
namespace {

constexpr auto terminal_interval = std::chrono::milliseconds(100);
constexpr auto log_interval = std::chrono::seconds(5);
constexpr std::size_t any_width = 1000;

/// Columns of the terminal of stderr; 80 if unknown.
std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

}  // namespace

StatusLine::StatusLine(bool quiet) : quiet_(quiet), on_terminal_(::isatty(STDERR_FILENO) == 1) {}

StatusLine::~StatusLine() {
  if (line_open_) std::fputc('\n', stderr);
}

void StatusLine::show(const Text& text) {
  if (quiet_) return;
  shown_ = Clock::now();
  if (!on_terminal_) {
    say_progress(text(any_width));
    return;
  }
  // Overwrites the rest of the last line with blanks, which works on every terminal; escape sequences do not.
  // The last column stays free, because some terminals wrap when it is written.
  const std::size_t width = terminal_width() - 1;
  const std::string padded = fmt::format("\r{:<{}}\r", text(width), width);
  std::fputs(padded.c_str(), stderr);
  std::fflush(stderr);
  line_open_ = true;
}

void StatusLine::clear() {
  if (!line_open_) return;
  std::fputs(fmt::format("\r{:<{}}\r", "", terminal_width() - 1).c_str(), stderr);
  std::fflush(stderr);
  line_open_ = false;
}

void StatusLine::update(const Text& text) {
  const auto wait = on_terminal_ ? Clock::duration(terminal_interval) : Clock::duration(log_interval);
  if (Clock::now() - shown_ >= wait) show(text);
}

}  // namespace palpate::app

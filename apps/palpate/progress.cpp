#include "progress.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <string_view>
#include <sys/ioctl.h>
#include <unistd.h>

#include "messages.hpp"
#include "numbers.hpp"

namespace palpate::app {
namespace {

constexpr auto terminal_interval = std::chrono::milliseconds(100);
constexpr auto log_interval = std::chrono::seconds(5);
constexpr std::size_t any_width = 1000;

/// Columns of the terminal behind stderr; 80 where it does not say.
std::size_t terminal_width() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

std::string duration_text(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

Progress::Progress(std::int64_t first_step, std::int64_t most_steps, bool quiet)
    : first_step_(first_step),
      most_steps_(most_steps),
      quiet_(quiet),
      on_terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', stderr);
}

std::string Progress::line(const StepMetrics& m, std::size_t width) const {
  const double elapsed = std::chrono::duration<double>(Clock::now() - start_).count();
  const double a_step = m.step > first_step_ ? elapsed / static_cast<double>(m.step - first_step_) : 0.0;
  const auto left = static_cast<double>(most_steps_ - m.step);
  const double percent =
      most_steps_ > 0 ? 100.0 * static_cast<double>(m.step) / static_cast<double>(most_steps_) : 100.0;
  const std::array<std::string, 5> pieces{
      fmt::format("step {}/{}", m.step, most_steps_), fmt::format("{:.0f}%", percent),
      counted(m.detection.contacts, "contact"), fmt::format("{} ms/step", short_text(1e3 * a_step)),
      left > 0 ? duration_text(a_step * left) + " left" : "took " + duration_text(elapsed)};
  std::string text;
  for (const std::string& piece : pieces) {
    if (text.size() + 2 + piece.size() > width) break;
    text.append(text.empty() ? "" : "  ").append(piece);
  }
  return text;
}

void Progress::show(const StepMetrics& metrics) {
  shown_ = Clock::now();
  if (!on_terminal_) {
    say_progress(line(metrics, any_width));
    return;
  }
  // Blanks over what the last line leaves, not an escape sequence: right on every terminal. The last column
  // stays free, because some terminals wrap when it is written.
  const std::size_t width = terminal_width() - 1;
  const std::string padded = fmt::format("\r{:<{}}\r", line(metrics, width), width);
  std::fputs(padded.c_str(), stderr);
  std::fflush(stderr);
  line_open_ = true;
}

void Progress::update(const StepMetrics& metrics) {
  if (quiet_) return;
  const auto wait = on_terminal_ ? Clock::duration(terminal_interval) : Clock::duration(log_interval);
  if (Clock::now() - shown_ >= wait) show(metrics);
}

void Progress::finish(const StepMetrics& metrics) {
  if (!quiet_) show(metrics);
}

}  // namespace palpate::app

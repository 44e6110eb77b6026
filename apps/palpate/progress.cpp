#include "progress.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>
#include <string_view>

#include "numbers.hpp"

namespace palpate::app {
namespace {

std::string duration_text(double seconds) {
  const auto whole = std::llround(seconds);
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {} s", whole / 60, whole % 60);
  return fmt::format("{} h {} min", whole / 3600, whole / 60 % 60);
}

}  // namespace

Progress::Progress(std::int64_t first_step, std::int64_t most_steps, bool quiet)
    : first_step_(first_step), most_steps_(most_steps), status_(quiet) {}

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

void Progress::update(const StepMetrics& metrics) {
  status_.update([&](std::size_t width) { return line(metrics, width); });
}

void Progress::finish(const StepMetrics& metrics) {
  status_.show([&](std::size_t width) { return line(metrics, width); });
}

}  // namespace palpate::app

#include "relax_model.hpp"

#include <fmt/format.h>
#include <stdexcept>

#include "exit_codes.hpp"
#include "messages.hpp"
#include "numbers.hpp"

namespace palpate::app {

std::optional<RelaxReport> relax_model(const Scene& scene, Model& model, int threads, bool quiet,
                                       const InterruptFlag& interrupt) {
  if (!scene.relax) return std::nullopt;
  const auto stop_if_interrupted = [&] {
    if (interrupt.requested()) throw std::runtime_error("interrupted while relaxing; there are no results");
  };
  const auto progress = [&](int steps, double deepest) {
    stop_if_interrupted();
    if (steps % 10 == 0 && !quiet) {
      say_progress(fmt::format("relaxing: step {} of {} at most, {} {} deep at most", steps,
                               scene.relax->max_steps, short_text(deepest), scene.units.length));
    }
  };
  RelaxReport report;
  as_input([&] {
    report = relax(model, scene.settings, *scene.relax, threads, progress);
    return 0;
  });
  stop_if_interrupted();
  if (!report.relaxed) {
    print_note(fmt::format("{}: overlaps of {} {} are left after relaxing, more than the {} {} allowed",
                           scene.source, short_text(report.deepest_after), scene.units.length,
                           short_text(report.allowed_depth), scene.units.length));
  }
  return report;
}

}  // namespace palpate::app

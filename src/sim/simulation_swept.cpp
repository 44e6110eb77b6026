#include <algorithm>

#include "contact/detector_steps.hpp"
#include "geometry/scaled_length.hpp"
#include "geometry/vector.hpp"
#include "sim/simulation_state.hpp"
#include "sim/unseen_passes.hpp"

// Stops points and edges that would pass through a body within a step: docs/continuous.md.
namespace palpate {

PredictedStep Simulation::State::predicted() const {
  return {.start = dynamics.start_positions(),
          .end = dynamics.end_positions(),
          .velocities = dynamics.mean_velocities(),
          .time_step = substep.length,
          .contacts = DetectorSteps::table(detector),
          .complete = !may_miss_contacts(metrics.detection)};
}

/// Whether parts that would pass are searched for and stopped.
bool Simulation::State::sweeps() const {
  return settings.detection.continuous != ContinuousDetection::off;
}

/// Whether the effort for passes is limited from now on, with so many further passes. The first search finds
/// 9 of 10 passes; the others are those that its stops cause, and each search costs a solve. Where there are
/// few passes in all, as with a needle, solves are cheap; so are those of small bodies. What is stopped may
/// have a whole body behind it that passes then, so the limit is for the pairs of bodies of which something
/// was stopped: see stop_passes().
bool Simulation::State::is_limited(std::int64_t passes) const {
  constexpr std::int64_t few = 100;
  constexpr std::int64_t little = 500'000;  // about 0.1 s
  return settings.detection.continuous == ContinuousDetection::limited && progress.stopped_passes > 0 &&
         progress.stopped_passes + passes > few &&
         progress.iterations_with_stops * std::ssize(bodies.points_rest()) > little;
}

/// If something must be stopped, and this effort is not limited, this many times more solves are allowed.
int Simulation::State::most_solves(bool stops_passes) const {
  constexpr int for_passes = 4;
  return (stops_passes && !is_limited(0) ? for_passes : 1) * settings.solver.max_solves;
}

/// Whether the last searches found as many passes as one before, or more. Where a body is moved through
/// another one, each solve would find thousands more.
bool Simulation::State::stops_fail() const {
  constexpr int most_searches = 3;
  constexpr std::int64_t many = 2000;
  return progress.failed_searches >= most_searches && progress.stopped_passes > many;
}

/// The largest speed of a point that stops may cause, m/s. What is hit by a heavier body is at most twice as
/// fast. A solution that is faster comes from stops that contradict each other, or push out what is deep.
double Simulation::State::most_speed_of_stops() const {
  constexpr double times = 2.0;
  const auto fastest = [](std::span<const Vec3> velocities) {
    double most = 0.0;
    for (const Vec3& v : velocities) most = std::max(most, scaled_length(v));
    return most;
  };
  return times * std::max(fastest(dynamics.velocities()), fastest(dynamics.mean_velocities())) +
         step_length() * length(settings.gravity);
}

/// Adds laws for pairs that would pass, and returns whether there are any. If no further solve is allowed, or
/// the search ends, only counts the pairs. A search whose passes are at most half as many as those of each
/// one before is never left out: there are few of them.
bool Simulation::State::stop_passes() {
  if (!sweeps()) return false;
  const auto stops =
      swept.find(threads, predicted(), DetectorSteps::may_touch(detector), response,
                 std::span(couplings).subspan(first_contact, first_speculative - first_contact));
  const bool ends_soon = 2 * std::ssize(stops) <= progress.least_stops;
  const bool may_stop =
      progress.may_stop && (ends_soon || swept.stops_new_pair() || !is_limited(std::ssize(stops)));
  if (!stops.empty() && may_stop) {
    progress.failed_searches = std::ssize(stops) < progress.least_stops ? 0 : progress.failed_searches + 1;
    progress.least_stops = std::min<std::int64_t>(progress.least_stops, std::ssize(stops));
  }
  const bool solves_again = may_stop && can_predict() && !stops_fail() && progress.solves < most_solves(true);
  progress.passes = swept.left() + (solves_again ? 0 : std::ssize(stops));
  metrics.passes = progress.passes;
  if (stops.empty() || !solves_again) return false;
  if (progress.stopped_passes == 0) progress.most_speed = most_speed_of_stops();
  swept.stop(predicted(), response, couplings);
  progress.stopped_passes += std::ssize(stops);
  metrics.stopped_passes = progress.stopped_passes;
  return true;
}

/// Where contacts may be missing, bodies that are near each other could pass however slowly they move.
void Simulation::State::count_passes() {
  const PairFilter& filter = DetectorSteps::may_touch(detector);
  if (may_miss_contacts(metrics.detection) || metrics.detection.unseen_pairs > 0) {
    swept.count(threads, predicted(), filter, 0.0);
  } else if (!sweeps()) {
    swept.count(threads, predicted(), filter);
  }
  metrics.pairs_that_could_pass = static_cast<std::int64_t>(swept.counts().body_pairs);
  metrics.thinnest = swept.counts().thinnest;
}

}  // namespace palpate

#include "peers/contest.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <tbb/global_control.h>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "sim/state_hash.hpp"

namespace palpate::bench {
namespace {

constexpr std::uint32_t trial_frames = 2;

/// A frame, with the expected answers.
struct Prepared {
  std::vector<Vec3> positions;
  std::vector<AimedEdge> edges;
  std::vector<Pair> expected;  ///< ascending
  [[nodiscard]] Frame frame() const { return {positions, edges}; }
};

/// Prepares frames, with a detector of its own.
class Preparation {
 public:
  explicit Preparation(const Course& course)
      : course_(&course), detector_(course.scene.bodies, settings(course), course.immovable, 1) {}

  Prepared prepare(std::uint32_t number) {
    Prepared result;
    course_->scene.place(number, result.positions);
    detector_.detect(result.positions);
    const Contacts& contacts = detector_.contacts();
    for (const BorderEdge& edge : detector_.border_edges())
      result.edges.push_back(
          {at(contacts.point, edge.contact), edge.free_point, at(contacts.body, edge.contact)});
    if (course_->task == Task::points_in_tets) {
      for (std::size_t c = 0; c < contacts.size(); ++c)
        result.expected.push_back({contacts.point[c], contacts.tet[c]});
    } else {
      for (const Crossing& crossing : detector_.crossings())
        result.expected.push_back({crossing.border_edge, crossing.triangle});
    }
    std::ranges::sort(result.expected);
    movers_ = static_cast<double>(detector_.counts().movers) / static_cast<double>(result.positions.size());
    return result;
  }
  /// Of the last frame.
  [[nodiscard]] double movers() const { return movers_; }

 private:
  static DetectionSettings settings(const Course& course) {
    DetectionSettings settings;
    settings.self_collision = course.scene.self_collision;
    settings.edge_contacts = false;  // peers are asked for points in tets and for border edges
    return settings;
  }
  const Course* course_;
  Detector detector_;
  double movers_ = 0.0;
};

void sort_unique(std::vector<Pair>& pairs) {
  std::ranges::sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

/// Pairs of a point and a body instead of a tet.
std::vector<Pair> by_body(const Bodies& bodies, const std::vector<Pair>& pairs) {
  std::vector<Pair> result;
  for (const Pair& pair : pairs)
    result.push_back({pair.first, bodies.body_of(at(bodies.tets(), pair.second))});
  sort_unique(result);
  return result;
}

/// Of the tets of one body that a point lies in, the lowest.
void keep_lowest(const Bodies& bodies, std::vector<Pair>& pairs) {
  const auto body = [&](const Pair& pair) { return bodies.body_of(at(bodies.tets(), pair.second)); };
  std::ranges::sort(pairs, [&](const Pair& a, const Pair& b) {
    return std::tuple(a.first, body(a), a.second) < std::tuple(b.first, body(b), b.second);
  });
  pairs.erase(
      std::unique(pairs.begin(), pairs.end(),
                  [&](const Pair& a, const Pair& b) { return a.first == b.first && body(a) == body(b); }),
      pairs.end());
}

std::size_t count_missing(const std::vector<Pair>& wanted, const std::vector<Pair>& there) {
  std::vector<Pair> missing;
  std::ranges::set_difference(wanted, there, std::back_inserter(missing));
  return missing.size();
}

/// Compares the answers with ours and counts them.
void compare(const Course& course, const Prepared& prepared, std::vector<Pair> pairs,
             Performance& performance) {
  std::vector<Pair> expected = prepared.expected;
  if (course.task == Task::points_in_tets) {
    if (performance.answer == Answer::exact) keep_lowest(course.scene.bodies, pairs);
    if (performance.answer == Answer::own_test) {
      pairs = by_body(course.scene.bodies, pairs);
      expected = by_body(course.scene.bodies, expected);
    }
  }
  sort_unique(pairs);
  const std::size_t missing = count_missing(expected, pairs);
  const std::size_t extra = count_missing(pairs, expected);
  performance.pairs += pairs.size();
  performance.missing += missing;
  performance.extra += extra;
  const bool wrong = (performance.answer == Answer::exact && missing + extra > 0) ||
                     (performance.answer == Answer::candidates && missing > 0);
  if (wrong)
    throw Error("benchmark",
                fmt::format("{}: {} ({})", course.scene.name, performance.name, performance.mode),
                fmt::format("{} answers missing and {} too many", missing, extra),
                fmt::format("the {} answers of the library", expected.size()));
}

/// The state of an entrant.
struct Runner {
  Performance performance;
  std::unique_ptr<Peer> peer;
  double trial_seconds = 0.0;
};

/// Seconds of a frame (of the processor for one thread, of the clock for several), with no more threads than
/// the entrant has.
double run_frame(const Course& course, Peer& peer, const Prepared& prepared, Performance& performance) {
  std::vector<Pair> pairs;
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(performance.threads));
  const Spent spent = peer.find(prepared.frame(), pairs);
  compare(course, prepared, std::move(pairs), performance);
  return performance.threads == 1 ? spent.processor : spent.passed;
}

/// Tries the modes on the first frames; the fastest in the last of them is used from then on.
Runner try_modes(const Course& course, const Entrant& entrant, const std::vector<Prepared>& trial,
                 std::vector<Trial>& trials) {
  Runner best;
  for (const Mode& mode : entrant.modes) {
    Runner runner;
    runner.performance.name = entrant.name;
    runner.performance.threads = entrant.threads;
    runner.performance.answer = entrant.answer;
    runner.performance.mode = mode.name;
    runner.peer = mode.make();
    for (const Prepared& prepared : trial)
      runner.trial_seconds = run_frame(course, *runner.peer, prepared, runner.performance);
    trials.push_back({entrant.name, entrant.threads, mode.name, runner.trial_seconds});
    if (best.peer == nullptr || runner.trial_seconds < best.trial_seconds) best = std::move(runner);
  }
  Performance& performance = best.performance;
  performance.pairs = performance.missing = performance.extra = 0;
  return best;
}

}  // namespace

ContestResult run_contest(const Course& course, std::vector<Entrant> entrants, const ContestEffort& effort) {
  ContestResult result;
  Preparation preparation(course);
  std::vector<Prepared> block;
  for (std::uint32_t f = 0; f < trial_frames; ++f) block.push_back(preparation.prepare(f));
  std::vector<Runner> runners;
  double frame_seconds = 0.0;
  for (const Entrant& entrant : entrants) {
    try {
      Runner runner = try_modes(course, entrant, block, result.trials);
      if (runner.trial_seconds > effort.patience) {
        result.dropped.push_back(
            {entrant.name, fmt::format("{}, {} thread{}: a frame took {:.3g} s, and {:.3g} s are allowed",
                                       course.scene.name, entrant.threads, entrant.threads == 1 ? "" : "s",
                                       runner.trial_seconds, effort.patience)});
        continue;
      }
      frame_seconds += runner.trial_seconds;
      runners.push_back(std::move(runner));
    } catch (const std::runtime_error& error) {
      if (dynamic_cast<const Error*>(&error) != nullptr) throw;  // a wrong answer
      result.dropped.push_back({entrant.name, error.what()});
    }
  }
  const auto frames = static_cast<std::uint32_t>(std::clamp(effort.seconds / frame_seconds, 3.0, 41.0));
  const std::uint32_t batch = std::clamp(frames / 2, 1U, 6U);
  result.hash = fnv1a({});
  for (std::uint32_t done = 0; done < frames; done += batch) {
    block.clear();
    for (std::uint32_t f = done; f < std::min(done + batch, frames); ++f) {
      block.push_back(preparation.prepare(trial_frames + f));
      result.movers += preparation.movers() / frames;
      // The number of frames depends on time, but three are always made.
      if (f < 3) result.hash = fnv1a(std::as_bytes(std::span(block.back().expected)), result.hash);
    }
    for (std::size_t i = 0; i < runners.size(); ++i) {
      Runner& runner = runners[(i + done / batch) % runners.size()];
      for (const Prepared& prepared : block)
        runner.performance.milliseconds.push_back(
            1e3 * run_frame(course, *runner.peer, prepared, runner.performance));
    }
  }
  result.frames = frames;
  result.edges = block.back().edges.size();
  result.answers = block.back().expected.size();
  for (Runner& runner : runners) result.performances.push_back(std::move(runner.performance));
  return result;
}

}  // namespace palpate::bench

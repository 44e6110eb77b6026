#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure/section.hpp"
#include "peers/peer.hpp"

namespace palpate::bench {

/// Limits of a contest, without the trial of modes.
struct ContestEffort {
  double seconds = 0.0;  ///< for all frames; at least three, at most 41 are measured
  /// Seconds that a frame may take in an entrant's fastest mode; who takes longer is dropped.
  double patience = 1e300;
};

/// Time of a mode in the trial.
struct Trial {
  std::string name;  ///< of the entrant
  int threads = 1;
  std::string mode;
  double seconds = 0.0;  ///< for a frame
};

/// Times and answers of an entrant.
struct Performance {
  std::string name;
  int threads = 1;
  Answer answer = Answer::exact;
  std::string mode;
  std::vector<double> milliseconds{};
  std::size_t pairs = 0;    ///< in all measured frames
  std::size_t missing = 0;  ///< answers of ours that it does not have
  std::size_t extra = 0;    ///< of its own that we do not have
};

struct ContestResult {
  std::size_t edges = 0;    ///< border edges of the last frame
  std::size_t answers = 0;  ///< ours, of the last frame
  std::size_t frames = 0;
  double movers = 0.0;     ///< mean fraction of points in another cell than in the frame before
  std::uint64_t hash = 0;  ///< of our answers
  std::vector<Trial> trials;
  std::vector<Performance> performances;
  std::vector<Absentee> dropped;  ///< entrants that failed, or were too slow
};

/// Each entrant tries its modes on two frames and keeps the fastest; then all alternate on frame
/// after frame. Throws Error if an exact test gives other answers than ours, or if ours are not among
/// candidates.
ContestResult run_contest(const Course& course, std::vector<Entrant> entrants, const ContestEffort& effort);

}  // namespace palpate::bench

#pragma once

#include <functional>
#include <string>
#include <vector>

#include "measure/section.hpp"
#include "peers/contest.hpp"
#include "peers/python_peer.hpp"

namespace palpate::bench {

/// A scene of a contest.
struct Heat {
  int cells = 0;         ///< of the stack of membranes; 0: the pile of balls and boxes
  double movers = 0.02;  ///< wanted fraction
};

struct PeersEffort {
  std::vector<Heat> heats;
  ContestEffort contest;
  std::vector<int> threads;
  double most_tets_of_trials = 0.0;  ///< of larger scenes modes are tried in the first heat only
  double python_most_tets = 1e300;   ///< peers in Python stay away from larger scenes
};
/// Up to a hundred thousand tets, all fractions of movers at ten thousand; and up to a million, all fractions
/// of movers, more frames.
PeersEffort quick_effort();
PeersEffort full_effort();

/// Runs a task in all heats, and reports each; absent peers are added to the list. `interrupted` is asked
/// before each heat: where it says yes, throws measure::Interrupted.
measure::Section contest_section(Task task, const PeersEffort& effort, const PythonPeers& python,
                                 std::vector<Absentee>& absent,
                                 const std::function<void(const std::string& line)>& tell,
                                 const std::function<bool()>& interrupted);

/// Who takes part, with what, and who does not, and why.
measure::Section peers_section(const std::vector<Absentee>& absent);

}  // namespace palpate::bench

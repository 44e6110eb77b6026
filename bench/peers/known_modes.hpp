#pragma once

#include <functional>
#include <vector>

#include "peers/contest.hpp"

namespace palpate::bench {

/// Results of the modes of entrants in trials of earlier scenes, so that slow ones need not be tried again.
/// With some of them a frame of a million tets takes minutes.
class KnownModes {
 public:
  /// A mode slower than the entrant's fastest one by this factor is not tried in larger scenes.
  static constexpr double hopeless = 4.0;

  /// \param trials  of a scene of so many tets
  void add(const std::vector<Trial>& trials, std::size_t tets);
  /// Takes out modes that were hopeless in smaller scenes, and entrants whose fastest mode took longer than
  /// the patience (seconds) in a scene of at most as many tets.
  void leave_out_hopeless(std::size_t tets, double patience, std::vector<Entrant>& entrants) const;
  /// Leaves only the fastest of scenes of as many tets, where there were such.
  void leave_fastest(std::size_t tets, std::vector<Entrant>& entrants) const;

 private:
  struct Known {
    Trial trial;
    std::size_t tets;
    double best;  ///< seconds of the entrant's fastest mode
  };
  void leave_out(std::vector<Entrant>& entrants, const std::function<bool(const Known&)>& condition) const;
  std::vector<Known> known_;
};

}  // namespace palpate::bench

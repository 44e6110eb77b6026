#include "peers/known_modes.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace palpate::bench {

void KnownModes::add(const std::vector<Trial>& trials, std::size_t tets) {
  std::map<std::pair<std::string, int>, double> best;
  for (const Trial& t : trials) {
    double& least = best.try_emplace({t.name, t.threads}, t.seconds).first->second;
    least = std::min(least, t.seconds);
  }
  for (const Trial& t : trials) known_.push_back({t, tets, best.at({t.name, t.threads})});
}

void KnownModes::leave_out_hopeless(std::size_t tets, double patience, std::vector<Entrant>& entrants) const {
  leave_out(entrants, [&](const Known& k) {
    return (k.tets < tets && k.trial.seconds > hopeless * k.best) || (k.tets <= tets && k.best > patience);
  });
}

void KnownModes::leave_fastest(std::size_t tets, std::vector<Entrant>& entrants) const {
  leave_out(entrants, [&](const Known& k) { return k.tets == tets && k.trial.seconds > k.best; });
}

void KnownModes::leave_out(std::vector<Entrant>& entrants,
                           const std::function<bool(const Known&)>& condition) const {
  for (Entrant& entrant : entrants) {
    std::erase_if(entrant.modes, [&](const Mode& mode) {
      return std::ranges::any_of(known_, [&](const Known& k) {
        return k.trial.name == entrant.name && k.trial.threads == entrant.threads &&
               k.trial.mode == mode.name && condition(k);
      });
    });
  }
  std::erase_if(entrants, [](const Entrant& entrant) { return entrant.modes.empty(); });
}

}  // namespace palpate::bench

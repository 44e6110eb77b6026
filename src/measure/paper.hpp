#pragma once

#include <functional>
#include <string>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

#include "measure/section.hpp"

/// The results of the paper ("Efficient uniform grids for collision handling in medical simulators"),
/// measured anew: one function an item. Times are of this machine, now; all else is the same everywhere.
namespace palpate::measure {

/// A scene of the paper as it is here.
struct PaperScene {
  std::string name;  ///< "stacking", "eye" or "skull"
  Model model;
  SimulationSettings settings;
  double meters_per_unit = 1.0;
};

/// How much is measured.
struct PaperEffort {
  int stacking_steps = 400;
  int organ_steps = 60;
  int rounds = 1;
  int error_steps = 100;  ///< of the runs that Table 2 compares
  std::vector<int> threads{};
};

/// What the paper says of its scenes (Table 1); zero where it says nothing.
Section scene_statistics(const std::vector<PaperScene>& scenes);
/// Fig. 6: index sort against serial hashing while membranes stack up.
Section stacking_timings(const PaperScene& stacking, const PaperEffort& effort);
/// Fig. 7: index sort against cuckoo hashing in the eye.
Section eye_timings(const PaperScene& eye, const PaperEffort& effort);
/// Sorts of 128,000 entries.
Section sort_timings(const PaperEffort& effort);
/// Z-curve against linear order.
Section order_timings(const std::vector<PaperScene>& scenes, const PaperEffort& effort);
/// Edge lengths of cells around the mean edge, and memory and load of each structure.
Section cell_sizes(const std::vector<PaperScene>& scenes, const PaperEffort& effort);
Section structures(const std::vector<PaperScene>& scenes, const PaperEffort& effort);
/// Table 2: a fixed number of cells per primitive.
Section approximate_errors(const std::vector<PaperScene>& scenes, const PaperEffort& effort);

/// Share p of the work that runs in parallel, from the speed-up s with n threads (paper 6, from Amdahl's
/// law): s = 1 / ((1 - p) + p / n).
double parallel_share(double speed_up, int threads);

}  // namespace palpate::measure

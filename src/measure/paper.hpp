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

/// What figures say of what the paper found.
struct Finding {
  Verdict verdict = Verdict::not_comparable;
  std::string why;
};

/// Fig. 7 from the time to insert points by cuckoo hashing over that of index sort, on one thread, and how
/// many times as fast the whole of each is with so many threads. The paper: index sort inserts faster, and
/// gains more by threads.
Finding eye_finding(double insertion, double index_speed_up, double cuckoo_speed_up, int threads);

/// Of edge lengths in a scene: times of cells of the mean edge and of `auto` over that of the fastest fixed
/// edge length, which is `best`.
struct CellSizeFigures {
  std::string scene;
  std::string best;
  double mean_edge = 1.0;
  double automatic = 1.0;
};
/// The paper: the mean edge length is best in general, that is here: within 3 % in most scenes.
Finding cell_size_finding(const std::vector<CellSizeFigures>& scenes);

/// Bytes a point of each structure in a scene, and the fraction of the cuckoo table that is full.
struct StructureFigures {
  double uniform = 0.0;
  double compact = 0.0;
  double hash = 0.0;
  double cuckoo = 0.0;
  double occupancy = 0.0;
};
/// The paper: all take less memory than the uniform grid, and cuckoo tables never failed to fill. At least
/// one scene.
Finding structures_finding(const std::vector<StructureFigures>& scenes, std::size_t second_tries);

/// Table 2 in a scene: mean times of a detection, and deviations of the runs with fewer cells.
struct ErrorFigures {
  std::string scene;
  double exact = 0.0;  ///< ms, as the next three
  double with_27 = 0.0;
  double with_8 = 0.0;
  double with_1 = 0.0;
  double largest = 0.0;       ///< deviation of a point, cm
  double largest_mean = 0.0;  ///< of the means over all points of a run, cm
};
/// The paper: fewer cells are faster, and errors are on average below 1 mm.
Finding errors_finding(const std::vector<ErrorFigures>& scenes);

/// Fraction p of the work that runs in parallel, from the speed-up s with n threads (paper 6, from Amdahl's
/// law): s = 1 / ((1 - p) + p / n).
double parallel_fraction(double speed_up, int threads);

}  // namespace palpate::measure

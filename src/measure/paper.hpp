#pragma once

#include <functional>
#include <string>
#include <vector>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

#include "measure/section.hpp"

/// The results of the paper ("Efficient uniform grids for collision handling in medical simulators"),
/// measured here: one function per item. Times depend on the machine; all else is the same everywhere.
namespace palpate::measure {

/// Our version of a scene of the paper. The stack is the paper's; eye and skull are other meshes.
struct PaperScene {
  std::string name;  ///< "stacking", "eye" or "skull"
  Model model;
  SimulationSettings settings;
  double meters_per_unit = 1.0;
};

/// The effort of a measurement: sizes and repetitions.
struct PaperEffort {
  int stacking_steps = 400;
  int organ_steps = 60;
  int rounds = 1;
  int error_steps = 100;  ///< steps of the runs for Table 2
  std::vector<int> threads{};
};

/// Table 1: statistics of the scenes, here and in the paper; zero where the paper has none.
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

/// Whether a finding of the paper is confirmed, with a text.
struct Finding {
  Verdict verdict = Verdict::not_comparable;
  std::string why;
};

/// Finding on Fig. 7. The paper: index sort inserts faster, and gains more by threads.
/// \param insertion  time to insert points by cuckoo hashing over that of index sort, on one thread
/// \param index_speed_up, cuckoo_speed_up  of both methods by threads
Finding eye_finding(double insertion, double index_speed_up, double cuckoo_speed_up, int threads);

/// Cell sizes in a scene: times with the mean edge length and with `auto`, over that of the fastest fixed
/// edge length, which is `best`.
struct CellSizeFigures {
  std::string scene;
  std::string best;
  double mean_edge = 1.0;
  double automatic = 1.0;
};
/// The paper: the mean edge length is best in general, here taken as: within 3 % in most scenes.
Finding cell_size_finding(const std::vector<CellSizeFigures>& scenes);

/// Bytes per point of each structure in a scene, and the load of the cuckoo table.
struct StructureFigures {
  double uniform = 0.0;
  double compact = 0.0;
  double hash = 0.0;
  double cuckoo = 0.0;
  double occupancy = 0.0;
};
/// The paper: all take less memory than the uniform grid, and the construction of cuckoo tables never failed.
/// At least one scene.
Finding structures_finding(const std::vector<StructureFigures>& scenes, std::size_t second_tries);

/// Table 2 in a scene: mean times of a detection, and deviations of the runs with fewer cells.
struct ErrorFigures {
  std::string scene;
  double exact = 0.0;  ///< ms, like the next three
  double with_27 = 0.0;
  double with_8 = 0.0;
  double with_1 = 0.0;
  double largest = 0.0;       ///< deviation of a point, cm
  double largest_mean = 0.0;  ///< largest mean over all points of a run, cm
};
/// The paper: fewer cells are faster, and errors are on average below 1 mm.
Finding errors_finding(const std::vector<ErrorFigures>& scenes);

/// Fraction p of the work that runs in parallel, from the speed-up s with n threads (paper 6, from Amdahl's
/// law): s = 1 / ((1 - p) + p / n).
double parallel_fraction(double speed_up, int threads);

}  // namespace palpate::measure

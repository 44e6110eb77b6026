#pragma once

#include <span>
#include <string>
#include <vector>

#include "measure/section.hpp"

/// Growth of time and memory with the size of the problem and with threads, for the stack of membranes with
/// more and more cells and trembling points (measure/query_scenes.hpp).
namespace palpate::measure {

struct ScalingEffort {
  std::vector<double> tets;       ///< wanted sizes for detections, ascending
  std::vector<double> step_tets;  ///< wanted sizes for whole steps
  double seconds = 0.0;           ///< time for the frames of one size
  std::vector<int> threads;
};
/// Effort up to a million tets; and up to ten million.
ScalingEffort quick_scaling();
ScalingEffort full_scaling();

/// Time of a detection by phases, memory, and the fit of growth; one thread.
Section growth(const ScalingEffort& effort, double most_tets);
/// The same frames with more and more threads. Throws Error if a thread count finds other contacts.
Section thread_scaling(const ScalingEffort& effort, double most_tets);
/// A whole step with its dynamics, 25 iterations of the solver.
Section step_growth(const ScalingEffort& effort, double most_tets);

/// The p of the line through (log x, log y) by least squares: y grows as x^p. At least two different x; all
/// numbers positive.
double growth_exponent(std::span<const double> x, std::span<const double> y);

/// Memory that this process has allocated and not freed, bytes (glibc; 0 with another allocator). Resident
/// pages are no measure of it, since freed memory is reused.
std::size_t allocated_bytes();

/// Times of a phase over the sizes.
struct PhaseGrowth {
  std::string name;
  std::vector<double> tets{};
  std::vector<double> milliseconds{};  ///< medians
  std::vector<double> lower{};         ///< lower quartiles, same length
  std::vector<double> upper{};
  /// Appends a size.
  void add(double size, const Measure& measure);
};
/// Adds to the section charts of time and of time per tet, and a text on the growth of each phase. It gives
/// an exponent only where the quartiles of neighbouring sizes do not overlap.
void describe_growth(Section& section, const std::string& what, const std::vector<PhaseGrowth>& phases);

}  // namespace palpate::measure

#pragma once

#include <span>
#include <string>
#include <vector>

#include "measure/section.hpp"

/// How time and memory grow with the size of the problem and with threads: the stack of membranes with more
/// and more cells, its points trembling (measure/query_scenes.hpp).
namespace palpate::measure {

struct ScalingEffort {
  std::vector<double> tets;       ///< wanted sizes of a detection, ascending
  std::vector<double> step_tets;  ///< of a whole step
  double seconds = 0.0;           ///< for the frames of one size
  std::vector<int> threads;
};
/// Up to a million tets; and up to ten million.
ScalingEffort quick_scaling();
ScalingEffort full_scaling();

/// Time of a detection by phases, memory, and the fit of growth; one thread.
Section growth(const ScalingEffort& effort, double most_tets);
/// The same frames with more and more threads. Throws Error where a thread count finds other contacts.
Section thread_scaling(const ScalingEffort& effort, double most_tets);
/// A whole step with its dynamics, 25 iterations of the solver.
Section step_growth(const ScalingEffort& effort, double most_tets);

/// The p of the line through (log x, log y) by least squares: y grows as x^p. At least two different x; all
/// numbers positive.
double growth_exponent(std::span<const double> x, std::span<const double> y);

/// Memory that this process has asked the allocator for and not given back, bytes (glibc; 0 where it is
/// another one that counts). Resident pages show less: freed memory is used again.
std::size_t allocated_bytes();

/// A phase of what is measured, over the sizes.
struct PhaseGrowth {
  std::string name;
  std::vector<double> tets{};
  std::vector<double> milliseconds{};  ///< medians
  std::vector<double> lower{};         ///< quartiles of the same, as many
  std::vector<double> upper{};
  /// Appends a size.
  void add(double size, const Measure& measure);
};
/// Charts of time and of time a tet, and a text on how each phase grows, into the section: an exponent only
/// where the quartiles of neighbouring sizes lie apart.
void describe_growth(Section& section, const std::string& what, const std::vector<PhaseGrowth>& phases);

}  // namespace palpate::measure

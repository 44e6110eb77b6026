#pragma once

#include <filesystem>
#include <vector>

#include "view/source.hpp"

namespace palpate::view {

/// Times of a step of a stored run.
struct StoredStep {
  double time = 0.0;  ///< simulated, at its end
  PhaseSeconds seconds{};
};

/// The times in metrics.csv (docs/results.md), in its order; empty where the file does not exist or has other
/// columns; a replay then has no times. A truncated last row is left out. O(size of the file).
std::vector<StoredStep> read_stored_times(const std::filesystem::path& metrics);

/// Means over the steps after `begin` until `end`, in simulated time; zeros where there are none.
PhaseSeconds mean_seconds(const std::vector<StoredStep>& steps, double begin, double end);

}  // namespace palpate::view

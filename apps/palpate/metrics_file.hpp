#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include <palpate/simulation.hpp>

#include "body_forces.hpp"
#include "csv_file.hpp"
#include "scene/outcome_probe.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// metrics.csv: a header with units, then a row for each step during the run. Columns that start with "wall"
/// are times of this machine; all others are the same in every run.
class MetricsFile {
 public:
  /// Creates or continues the file, as the constructors of CsvFile do.
  MetricsFile(std::filesystem::path path, const Units& units, const OutcomeProbe& outcomes);
  MetricsFile(std::filesystem::path path, std::uint64_t bytes);

  /// \param forces        of the step
  /// \param outcomes      of the step
  /// \param step_seconds  wall time of the whole step; 0 for the start
  void add(const StepMetrics& metrics, const ForcesOfStep& forces, std::span<const OutcomeValue> outcomes,
           double step_seconds);
  void flush() { file_.flush(); }
  void sync() { file_.sync(); }
  [[nodiscard]] std::uint64_t bytes() const { return file_.bytes(); }

 private:
  CsvFile file_;
};

}  // namespace palpate::app

#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>

#include <palpate/simulation.hpp>

#include "scene/scene.hpp"

namespace palpate::app {

/// metrics.csv: a header with units, then a row for each step as the run goes.
///
/// Rows reach the file at least each second of running and only as whole lines, so that a run that is killed
/// keeps what it did; a file that is removed meanwhile is an error. Times that start with "wall" are of this
/// machine; all else is the same on every run.
class MetricsFile {
 public:
  /// Starts the file anew. Throws Error naming the path if it cannot be written; so do the others.
  MetricsFile(std::filesystem::path path, const Units& units);
  /// Goes on with a file after its first so many bytes; what follows them is cut off. Throws Error where it
  /// has fewer.
  MetricsFile(std::filesystem::path path, std::uint64_t bytes);
  ~MetricsFile();
  MetricsFile(const MetricsFile&) = delete;
  MetricsFile& operator=(const MetricsFile&) = delete;

  /// \param step_seconds  wall time of the whole step; 0 for the start
  void add(const StepMetrics& metrics, double step_seconds);
  void flush();
  /// flush(), and waits until all rows are on the disk.
  void sync();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  ///< in the file

 private:
  void open(int flags);
  [[noreturn]] void fail(const char* doing, const char* expected) const;

  std::filesystem::path path_;
  std::string lines_;        ///< not yet in the file
  std::uint64_t bytes_ = 0;  ///< in the file
  std::chrono::steady_clock::time_point flushed_ = std::chrono::steady_clock::now();
  int descriptor_ = -1;
};

}  // namespace palpate::app

#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <palpate/simulation.hpp>

#include "io/series_writer.hpp"

namespace palpate::app {

/// Writes the states of a run as a series of .vtu frames: every so many steps, and those it is told to.
class FrameWriter {
 public:
  /// Throws Error where the folder cannot be written; so does add().
  FrameWriter(const std::filesystem::path& folder, int every);

  /// Writes the state if its step is due, or if `always`; never the same step twice.
  void add(const Simulation& simulation, bool always = false);

  [[nodiscard]] std::size_t count() const { return series_.frame_count(); }
  [[nodiscard]] const std::filesystem::path& collection() const { return series_.collection_path(); }

 private:
  io::SeriesWriter series_;
  int every_;
  std::int64_t last_step_ = -1;
  std::vector<std::uint8_t> in_contact_;
  std::vector<double> depths_;
};

}  // namespace palpate::app

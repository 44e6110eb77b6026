#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <palpate/simulation.hpp>

#include "field_maxima.hpp"
#include "io/series_writer.hpp"
#include "scene/scene.hpp"

namespace palpate::app {

/// The frames that a run has written.
struct FramesSoFar {
  std::vector<double> times;
  std::int64_t last_step = -1;  ///< step of the last frame; -1: none
  std::vector<FieldMaximum> maxima{};
};

/// Writes states of a run as a series of .vtu frames: one every so many steps, and others if `always` is set.
class FrameWriter {
 public:
  /// \param output  interval and fields
  /// \param so_far  frames of the run that is resumed; other frames in the folder are removed
  ///
  /// Throws Error if the folder cannot be written; so does add().
  FrameWriter(const std::filesystem::path& folder, const OutputSettings& output, const Units& units,
              const FramesSoFar& so_far = {});

  /// Writes the state if its step is due, or if `always`; never the same step twice.
  void add(const Simulation& simulation, bool always = false);

  [[nodiscard]] std::size_t count() const { return series_.frame_count(); }
  /// Numbers of the run's frames whose files are missing.
  [[nodiscard]] const std::vector<std::size_t>& missing() const { return series_.missing_frames(); }
  [[nodiscard]] FramesSoFar so_far() const { return {series_.times(), last_step_, maxima_}; }
  /// The maxima of the fields of frames, over all frames.
  [[nodiscard]] const std::vector<FieldMaximum>& maxima() const { return maxima_; }
  [[nodiscard]] const std::filesystem::path& collection() const { return series_.collection_path(); }

 private:
  io::SeriesWriter series_;
  int every_;
  std::vector<std::string> fields_;
  Units units_;
  std::int64_t last_step_;
  std::vector<FieldMaximum> maxima_;
  std::vector<std::uint8_t> in_contact_;
  std::vector<double> depths_;
};

}  // namespace palpate::app

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/vtu_writer.hpp"

namespace palpate::io {

/// Writes the frames of a run, and the ParaView collection with their times:
///
/// FOLDER/NAME.pvd FOLDER/frames/frame_000000.vtu, frame_000001.vtu, ...
///
/// The .pvd is replaced, whole, after each frame, so that an interrupted run leaves a series that opens and
/// lists only complete frames.
class SeriesWriter {
 public:
  /// Creates the folders, an empty collection, and removes the frames (frame_*.vtu, six digits or more) that
  /// an earlier run left in FOLDER/frames. Throws Error naming the path that cannot be created or written.
  ///
  /// \param times  times of the frames of a resumed run, which stay. A frame whose file is missing is left
  ///               out of the collection: missing_frames().
  SeriesWriter(std::filesystem::path folder, std::string name, std::vector<double> times = {});

  /// Writes the next frame, then the collection. Throws as write_frame() does; the frame is then not in the
  /// series. O(n_points + n_tets + frames so far).
  void add(const Bodies& bodies, const FrameState& state);
  /// add() for any mesh and arrays; `data.time` is set to `time`.
  void add(double time, VtuData data);

  [[nodiscard]] const std::filesystem::path& collection_path() const { return collection_path_; }
  /// Number of frames in the collection.
  [[nodiscard]] std::size_t frame_count() const { return times_.size() - missing_.size(); }
  /// Times of all frames that were written, also of deleted ones.
  [[nodiscard]] const std::vector<double>& times() const { return times_; }
  /// Numbers of frames that had been deleted when the run was resumed, ascending.
  [[nodiscard]] const std::vector<std::size_t>& missing_frames() const { return missing_; }
  /// The path of a frame: FOLDER/frames/frame_NNNNNN.vtu.
  [[nodiscard]] std::filesystem::path frame_path(std::size_t frame) const;

 private:
  void list_frame(double time);

  std::filesystem::path folder_;
  std::filesystem::path collection_path_;
  std::vector<double> times_;
  std::vector<std::size_t> missing_;
};

}  // namespace palpate::io

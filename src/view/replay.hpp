#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <palpate/detection.hpp>

#include "io/series_reader.hpp"
#include "scene/scene.hpp"
#include "view/source.hpp"
#include "view/stored_forces.hpp"
#include "view/stored_stages.hpp"
#include "view/stored_times.hpp"

namespace palpate::view {

/// The frames that `palpate run` left in a folder. Contacts are detected again at the stored positions. This
/// gives the contacts of the run, since they depend only on positions, and on the bodies of each stage.
/// Displacements are relative to the
/// first frame. Fields are those in the frames, forces those in forces.csv.
class ReplaySource : public Source {
 public:
  /// Reads run.json, the list of frames and the first frame. Throws Error naming the file that is missing or
  /// does not fit the others; so do advance() and apply(Seek) for a frame.
  explicit ReplaySource(const std::filesystem::path& folder, int threads);

  [[nodiscard]] const Stage& stage() const override { return stage_; }
  [[nodiscard]] const Bodies& bodies() const override { return bodies_; }
  [[nodiscard]] std::span<const Vec3> positions() const override { return positions_; }
  [[nodiscard]] const Detector& detector() const override { return *detector_; }
  [[nodiscard]] double time() const override { return frames_[frame_].time; }
  [[nodiscard]] std::optional<double> interval() const override;
  void advance() override { show(frame_ + 1); }
  void reset() override { show(0); }
  [[nodiscard]] const PhaseSeconds& seconds() const override { return seconds_; }
  [[nodiscard]] nlohmann::ordered_json counts() const override;
  [[nodiscard]] nlohmann::ordered_json forces() const override { return forces_.at_time(time()); }
  /// A field of the frames (`output.fields` of the scene).
  [[nodiscard]] std::vector<double> field(const std::string& name) const override;
  [[nodiscard]] nlohmann::ordered_json settings() const override { return settings_json(scene_.settings); }
  void apply(Client client, const Change& change) override;
  void apply(Client client, const Pull& pull) override;
  void apply(Client client, const MovePull& pull) override;
  void apply(Client client, const LetGo& pull) override;
  void apply(Client client, const DriveMotion& command) override;
  void apply(Client client, const ResumeMotion& command) override;
  void apply(Client client, const Seek& seek) override;
  void forget(Client client) override;

 private:
  void read_run(const std::filesystem::path& folder);
  [[nodiscard]] std::unique_ptr<Detector> make_detector(std::size_t stage) const;
  void make_bodies(const std::filesystem::path& folder);
  void show(std::size_t frame);
  [[nodiscard]] nlohmann::ordered_json about() const;
  [[nodiscard]] nlohmann::ordered_json stored_fields_json() const;

  /// A body as listed in run.json.
  struct Listed {
    std::string name;
    std::uint32_t points = 0;
    std::uint32_t tets = 0;
    bool obstacle = false;
  };
  std::vector<io::SeriesFrame> frames_;
  std::vector<StoredStep> steps_;
  StoredForces forces_;
  Scene scene_;
  std::vector<Listed> listed_;
  Bodies bodies_;
  StoredStages stages_;
  int threads_;
  std::unique_ptr<Detector> detector_;
  std::size_t stage_of_detector_ = 0;
  std::vector<Vec3> positions_;
  std::size_t frame_ = 0;
  PhaseSeconds seconds_{};
  Stage stage_;
};

}  // namespace palpate::view

#include "view/replay.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "geometry/vector.hpp"
#include "io/file_bytes.hpp"
#include "io/point_arrays.hpp"
#include "scene/json_text.hpp"
#include "sim/holds.hpp"
#include "view/colour_field.hpp"

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void refuse(const std::string& what) {
  throw Error(what, "", "stored results", "a running simulation: 'palpate view SCENE'");
}

}  // namespace

ReplaySource::ReplaySource(const std::filesystem::path& folder, int threads) : threads_(threads) {
  read_run(folder);
  const std::filesystem::path collection = folder / "frames.pvd";
  frames_ = io::read_series(collection);
  if (frames_.empty()) throw Error(collection.string(), "", "no frame", "one or more frames");
  steps_ = read_stored_times(folder / "metrics.csv");
  make_bodies(folder);
  std::vector<std::string> names;
  names.reserve(listed_.size());
  for (const Listed& body : listed_) names.push_back(body.name);
  forces_ = StoredForces(folder / "forces.csv", names);
  show(0);
  stage_.origin = extent_of(positions_).center;
  stage_.about = about();
}

void ReplaySource::read_run(const std::filesystem::path& folder) {
  const std::string source = (folder / "run.json").string();
  const nlohmann::json run = parse_json(io::read_file(folder / "run.json", "the report of a run"), source);
  try {
    scene_ = read_scene_text(run.at("scene").dump(), source);
    for (const nlohmann::json& body : run.at("bodies")) {
      listed_.push_back({body.at("name"), body.at("points"), body.at("tets"), body.at("obstacle")});
    }
    std::vector<double> ends;
    for (const nlohmann::json& stage : run.value("stages", nlohmann::json::array()))
      ends.push_back(stage.at("time"));
    stages_ = StoredStages(scene_, std::move(ends));
  } catch (const nlohmann::json::exception& error) {
    const std::string why = error.what();  // "[json.exception…] key 'scene' not found"
    throw Error(source, "", "other content (" + why.substr(why.find(']') + 2) + ")",
                "what 'palpate run' writes");
  }
  if (listed_.size() != scene_.bodies.size()) {
    throw Error(source, "bodies", std::to_string(listed_.size()),
                std::to_string(scene_.bodies.size()) + ", as the scene has");
  }
}

/// Splits the first frame into bodies: points and tets of a frame are ordered by body.
void ReplaySource::make_bodies(const std::filesystem::path& folder) {
  const TetMesh all = io::read_mesh(frames_.front().file).mesh;
  std::size_t points = 0;
  std::size_t tets = 0;
  for (const Listed& body : listed_) {
    points += body.points;
    tets += body.tets;
  }
  if (points != all.points.size() || tets != all.tets.size()) {
    throw Error((folder / "run.json").string(), "bodies",
                std::to_string(points) + " points and " + std::to_string(tets) + " tets",
                "the numbers of the scene: " + frames_.front().file.string());
  }
  auto point = all.points.begin();
  auto tet = all.tets.begin();
  Index first = 0;
  for (const Listed& body : listed_) {
    TetMesh mesh;
    mesh.points.assign(point, point + body.points);
    mesh.tets.assign(tet, tet + body.tets);
    for (Tet& corners : mesh.tets) {
      for (Index& corner : corners) corner -= first;
    }
    point += body.points;
    tet += body.tets;
    first += static_cast<Index>(body.points);
    bodies_.add(body.name, std::move(mesh));
  }
}

/// With the contacts of a stage: those that are absent have none.
std::unique_ptr<Detector> ReplaySource::make_detector(std::size_t stage) const {
  std::vector<std::uint8_t> obstacles;
  for (std::size_t b = 0; b < listed_.size(); ++b) {
    const bool rigid = stage == 0 ? listed_[b].obstacle : stages_.rigid(stage)[b] != 0;
    obstacles.push_back(rigid || stages_.absent(stage)[b] != 0 ? 1 : 0);
  }
  const DetectionSettings settings = without_absent(scene_.settings.detection, stages_.absent(stage));
  return std::make_unique<Detector>(bodies_, settings, obstacles, threads_);
}

void ReplaySource::show(std::size_t frame) {
  io::MeshFile file = io::read_mesh(frames_[frame].file);
  if (file.mesh.points.size() != bodies_.points_rest().size()) {
    throw Error(frames_[frame].file.string(), "", std::to_string(file.mesh.points.size()) + " points",
                std::to_string(bodies_.points_rest().size()) + ", as the first frame has");
  }
  const std::size_t stage = stages_.stage_of(frames_[frame].time);
  std::unique_ptr<Detector> other;
  if (!detector_ || stage != stage_of_detector_) other = make_detector(stage);
  (other ? *other : *detector_).detect(file.mesh.points);
  if (other) detector_ = std::move(other);
  stage_of_detector_ = stage;
  positions_ = std::move(file.mesh.points);
  const double before = frame == 0 ? frames_[0].time : frames_[frame - 1].time;
  seconds_ = mean_seconds(steps_, before, frames_[frame].time);
  frame_ = frame;
}

std::optional<double> ReplaySource::interval() const {
  if (frame_ + 1 >= frames_.size()) return std::nullopt;
  return frames_[frame_ + 1].time - frames_[frame_].time;
}

Json ReplaySource::about() const {
  const Surface surface(bodies_);
  Json list = bodies_json(bodies_, surface, scene_);
  Json json = about_json(scene_, list, extent_of(bodies_.points_rest()).diagonal);
  json["mode"] = "replay";
  json["frames"] = frames_.size();
  json["motions"] = Json::array();
  json["stages"] = stage_names_json(scene_);
  json["fields"] = stored_fields_json();
  if (forces_.any()) json["forces"] = forces_.history();
  return json;
}

Json ReplaySource::stored_fields_json() const {
  Json list = Json::array();
  for (const io::PointArrayInfo& array : io::list_point_arrays(frames_.front().file)) {
    for (const ColourField& field : colour_fields()) {
      if (field.info->name == array.name && field.info->components == array.components)
        list.push_back(field_json(field));
    }
  }
  return list;
}

std::vector<double> ReplaySource::field(const std::string& name) const {
  const ColourField* const colour = find_colour_field(name);
  if (colour == nullptr) return {};
  const FieldInfo& info = *colour->info;
  std::vector<double> values = io::read_point_array(frames_[frame_].file, std::string(info.name));
  if (values.size() != static_cast<std::size_t>(info.components) * positions_.size()) return {};
  return colour_values(*colour, std::move(values));
}

Json ReplaySource::counts() const {
  Json json = detection_json(detector_->counts());
  double deepest = 0.0;
  for (const double depth : detector_->contacts().depth) deepest = std::max(deepest, depth);
  for (const double depth : detector_->edge_contacts().depth) deepest = std::max(deepest, depth);
  json["deepest"] = deepest;
  json["frame"] = frame_;
  if (stages_.any()) json["plan"] = stages_.json(time());
  return json;
}

void ReplaySource::apply(Client /*client*/, const Seek& seek) {
  if (seek.frame < 0 || static_cast<std::size_t>(seek.frame) >= frames_.size()) {
    throw Error("message from the page", "seek.frame", std::to_string(seek.frame),
                "less than " + std::to_string(frames_.size()) + ", the number of frames");
  }
  show(static_cast<std::size_t>(seek.frame));
}

void ReplaySource::apply(Client /*client*/, const Change& /*change*/) {
  refuse("change");
}
void ReplaySource::apply(Client /*client*/, const Pull& /*pull*/) {
  refuse("pull");
}
void ReplaySource::apply(Client /*client*/, const MovePull& /*pull*/) {
  refuse("move_pull");
}
void ReplaySource::apply(Client /*client*/, const LetGo& /*pull*/) {
  refuse("let_go");
}
void ReplaySource::apply(Client /*client*/, const DriveMotion& /*command*/) {
  refuse("drive_motion");
}
void ReplaySource::apply(Client /*client*/, const ResumeMotion& /*command*/) {
  refuse("resume_motion");
}
void ReplaySource::forget(Client /*client*/) {}

}  // namespace palpate::view

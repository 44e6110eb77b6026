#include "view/stored_stages.hpp"

#include <algorithm>
#include <utility>

#include <palpate/error.hpp>

namespace palpate::view {
namespace {

using Json = nlohmann::ordered_json;

/// Sets the flag of the body of this name.
void set(const Scene& scene, const std::string& name, std::vector<std::uint8_t>& flags, std::uint8_t value) {
  const auto body = std::ranges::find(scene.bodies, name, &SceneBody::name);
  if (body != scene.bodies.end()) flags[static_cast<std::size_t>(body - scene.bodies.begin())] = value;
}

Json indices_of(const std::vector<std::uint8_t>& flags) {
  Json list = Json::array();
  for (std::size_t b = 0; b < flags.size(); ++b)
    if (flags[b] != 0) list.push_back(b);
  return list;
}

}  // namespace

StoredStages::StoredStages(const Scene& scene, std::vector<double> ends)
    : ends_(std::move(ends)), slack_(0.5 * scene.settings.time_step) {
  if (ends_.size() > scene.stages.size()) {
    throw Error(scene.source, "stages", std::to_string(ends_.size()) + " of them",
                "at most " + std::to_string(scene.stages.size()) + ", as the scene has");
  }
  BodiesOfStage bodies;
  for (const SceneBody& body : scene.bodies) {
    bodies.absent.push_back(body.absent ? 1 : 0);
    bodies.rigid.push_back(is_rigid(body) ? 1 : 0);
  }
  bodies_.push_back(bodies);
  for (const palpate::Stage& stage : scene.stages) {
    for (const std::string& name : stage.insert.names) set(scene, name, bodies.absent, 0);
    for (const std::string& name : stage.remove.names) set(scene, name, bodies.absent, 1);
    for (const StageBody& release : stage.release)
      if (!release.part) set(scene, release.body, bodies.rigid, 0);
    bodies_.push_back(bodies);
    names_.push_back(stage.name);
  }
}

std::size_t StoredStages::stage_of(double time) const {
  if (!any()) return 0;
  std::size_t ended = 0;
  while (ended < ends_.size() && time > ends_[ended] + slack_) ++ended;
  return std::min(ended + 1, names_.size());
}

Json StoredStages::json(double time) const {
  const std::size_t stage = stage_of(time);
  const bool done = ends_.size() == names_.size() && time > ends_.back() - slack_;
  return {{"stage", names_[stage - 1]},
          {"number", stage},
          {"done", done},
          {"absent", indices_of(absent(stage))},
          {"rigid", indices_of(rigid(stage))},
          {"warnings", Json::array()}};
}

Json stage_names_json(const Scene& scene) {
  Json names = Json::array();
  for (const palpate::Stage& stage : scene.stages) names.push_back(stage.name);
  return names;
}

}  // namespace palpate::view

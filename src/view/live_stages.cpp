#include <algorithm>

#include "geometry/vector.hpp"
#include "view/live.hpp"

// The stages of a scene that pages watch.
namespace palpate::view {

using Json = nlohmann::ordered_json;

void LiveSource::begin_stage() {
  const Vec3 gravity = simulation_.settings().gravity;
  const std::optional<ModelChange> change = stages_.begin(simulation_);
  if (!change) return;
  take_gravity_of_stage(gravity);
  take_constraints(*change);
  take_motions();
  limits_ = pull_limits();
  std::erase_if(pulls_, [&](const auto& pull) {
    const bool ends = !is_free(at(surface_.points(), pull.second.vertex));
    if (ends) simulation_.release(pull.second.grab);
    return ends;
  });
}

/// Gravity that a page has set lasts until a stage sets another.
void LiveSource::take_gravity_of_stage(const Vec3& before) {
  if (stages_.stage().gravity) {
    if (!gravity_before_) gravity_before_ = before;
    return;
  }
  SimulationSettings settings = simulation_.settings();
  if (settings.gravity == before) return;
  settings.gravity = before;
  simulation_.change(settings);
}

void LiveSource::take_constraints(const ModelChange& change) {
  const std::size_t count = bodies().points_rest().size();
  std::vector<std::uint8_t>& fixed = present_.fixed_points;
  fixed.resize(count, 0);
  for (const Index body : change.release_bodies) {
    const auto [begin, end] = at(bodies().bodies(), body).points;
    std::fill(fixed.begin() + begin, fixed.begin() + end, 0);
  }
  for (const Index point : change.release_points) at(fixed, point) = 0;
  for (const Index point : change.fix) at(fixed, point) = 1;
  for (const PointMove& move : change.moves)
    for (const Index point : move.points) at(fixed, point) = 0;
  const std::span<const Index> motions = simulation_.motion_of_points();
  present_.motion_of_point.assign(motions.begin(), motions.end());
  present_.ties = simulation_.ties();
  present_.obstacles.clear();
  present_.absent.clear();
  for (Index b = 0; b < bodies().body_count(); ++b) {
    present_.obstacles.push_back(simulation_.is_rigid(b) ? 1 : 0);
    present_.absent.push_back(is_absent(b) ? 1 : 0);
  }
}

/// Pages move each body along the motion that the stage gave it.
void LiveSource::take_motions() {
  for (std::size_t m = 0; m < movable_.size(); ++m) {
    if (movable_[m] < 0) continue;
    const Index first = at(bodies().bodies(), movable_[m]).points.begin;
    const Index number = is_absent(movable_[m]) ? -1 : at(simulation_.motion_of_points(), first);
    if (number != motions_.number(m))
      motions_.replace(m, number, number < 0 ? Motion{} : simulation_.motion(number));
  }
}

std::size_t LiveSource::begun_stages() const {
  const StageProgress& progress = stages_.progress();
  return progress.endings.size() + (progress.begun ? 1U : 0U);
}

Json LiveSource::bodies_with(bool (LiveSource::*has)(Index) const) const {
  Json list = Json::array();
  for (Index b = 0; b < bodies().body_count(); ++b)
    if ((this->*has)(b)) list.push_back(b);
  return list;
}

/// The stage, and what stages have changed of bodies.
Json LiveSource::stages_json() const {
  return {{"stage", stages_.stage().name},
          {"number", begun_stages()},
          {"done", stages_.done()},
          {"absent", bodies_with(&LiveSource::is_absent)},
          {"rigid", bodies_with(&LiveSource::is_rigid_now)},
          {"warnings", stages_.warnings()}};
}

}  // namespace palpate::view

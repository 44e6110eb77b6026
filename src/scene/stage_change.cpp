#include "scene/stage_change.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "number_text.hpp"
#include "scene/json_text.hpp"
#include "scene/near.hpp"
#include "scene/scene_motion.hpp"
#include "scene/selector.hpp"
#include "scene/surface_load.hpp"

namespace palpate {

/// Computes the changes of each stage, in order.
class StageReader {
 public:
  StageReader(const Scene& scene, const Bodies& bodies) : scene_(scene), bodies_(bodies) {
    for (const SceneBody& body : scene.bodies) absent_.push_back(body.absent ? 1 : 0);
    for (const SceneBody& body : scene.bodies) rigid_.push_back(is_rigid(body) ? 1 : 0);
  }

  StageChanges::Changes read(std::size_t stage) {
    stage_ = &scene_.stages[stage];
    path_ = element_path("stages", stage);
    changes_ = {};
    read_presence();
    for (std::size_t i = 0; i < stage_->release.size(); ++i) release(stage_->release[i], key("release", i));
    for (std::size_t i = 0; i < stage_->fix.size(); ++i) {
      const std::vector<Index> points = part_of(stage_->fix[i], key("fix", i));
      if (at(rigid_, named(stage_->fix[i].body)) != 0) {
        fail(key("fix", i) + ".body", "the rigid body '" + stage_->fix[i].body + "'",
             "a body that deforms; 'move' with one keyframe lets a rigid body stand still");
      }
      changes_.fixed.fix.insert(changes_.fixed.fix.end(), points.begin(), points.end());
    }
    for (std::size_t i = 0; i < stage_->move.size(); ++i) move(stage_->move[i], key("move", i));
    for (const StageCut& cut : stage_->untie)
      changes_.cuts.push_back({named(cut.bodies.names[0]), named(cut.bodies.names[1])});
    for (std::size_t i = 0; i < stage_->tie.size(); ++i) tie(stage_->tie[i], key("tie", i));
    for (std::size_t i = 0; i < stage_->loads.size(); ++i) load(stage_->loads[i], key("loads", i));
    return std::move(changes_);
  }

 private:
  [[nodiscard]] std::string key(const char* list, std::size_t i) const {
    return element_path(path_ + "." + list, i);
  }
  [[noreturn]] void fail(const std::string& where, const std::string& found,
                         const std::string& expected) const {
    throw Error(scene_.source, where, found, expected);
  }
  [[nodiscard]] Index named(const std::string& body) const { return body_named(scene_, body, path_, -1); }
  [[nodiscard]] const SceneBody& of_scene(Index body) const { return at(scene_.bodies, body); }

  void read_presence() {
    for (std::size_t i = 0; i < stage_->insert.names.size(); ++i) {
      const Index body = named(stage_->insert.names[i]);
      if (at(absent_, body) == 0) {
        fail(key("insert", i), "'" + of_scene(body).name + "', which is in the scene already",
             "a body that was removed, or starts with \"absent\": true");
      }
      at(absent_, body) = 0;
      changes_.fixed.insert.push_back(body);
    }
    for (std::size_t i = 0; i < stage_->remove.names.size(); ++i) {
      const Index body = present(stage_->remove.names[i], key("remove", i));
      check_unattached(body, key("remove", i));
      at(absent_, body) = 1;
      changes_.fixed.remove.push_back(body);
    }
  }
  Index present(const std::string& name, const std::string& where) const {
    const Index body = named(name);
    if (at(absent_, body) != 0)
      fail(where, "'" + name + "', which is not in the scene at this stage", "a body that is in the scene");
    return body;
  }
  void check_unattached(Index body, const std::string& where) const {
    for (const SceneBody& other : scene_.bodies) {
      const bool attached = std::ranges::any_of(
          other.attached, [&](const Attachment& a) { return a.to == of_scene(body).name; });
      if (attached && at(rigid_, body) != 0) {
        fail(where, "'" + of_scene(body).name + "', which '" + other.name + "' is attached to",
             "a body that no other is attached to");
      }
    }
  }

  void release(const StageBody& release, const std::string& where) {
    if (release.part) {
      const std::vector<Index> points = part_of(release, where);
      auto& all = changes_.fixed.release_points;
      all.insert(all.end(), points.begin(), points.end());
      return;
    }
    const Index body = present(release.body, where + ".body");
    if (!of_scene(body).material) {
      fail(where + ".body", "'" + release.body + "', which has no material",
           "a body with a material, so that it can deform");
    }
    check_unattached(body, where + ".body");
    at(rigid_, body) = 0;
    changes_.fixed.release_bodies.push_back(body);
  }
  void move(const StageMove& move, const std::string& where) {
    PointMove points{.points = part_of({move.body, move.part}, where), .motion = motion_of(move.motion)};
    const Index body = named(move.body);
    if (at(rigid_, body) != 0 && !move.part) add_attached(body, points.points);
    std::vector<Keyframe>& keys = points.motion.keyframes;
    const Keyframe& first = keys.front();
    const Vec3 turned{first.quaternion[1], first.quaternion[2], first.quaternion[3]};
    if (first.time > 0.0) {
      keys.insert(keys.begin(), Keyframe{});
    } else if (first.translate != Vec3{} || turned != Vec3{}) {
      fail(where + ".motion.keyframes[0]", "a pose at time 0 that differs from the body's current pose",
           "a keyframe at a later time; the motion starts at the current pose");
    }
    changes_.fixed.moves.push_back(std::move(points));
  }
  /// Adds the points of other bodies that are attached to a rigid body.
  void add_attached(Index body, std::vector<Index>& points) const {
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      const SceneBody& tissue = scene_.bodies[b];
      for (std::size_t a = 0; a < tissue.attached.size(); ++a) {
        if (tissue.attached[a].to != of_scene(body).name) continue;
        const auto more = selected_of(static_cast<Index>(b), tissue.attached[a].points,
                                      element_path(path_of(b) + ".attached", a));
        points.insert(points.end(), more.begin(), more.end());
      }
    }
  }
  void tie(const StageTie& tie, const std::string& where) {
    const Index to = present(tie.to, where + ".to");
    const Index body = present(tie.body, where + ".body");
    if (to == body) fail(where + ".to", "'" + tie.to + "', the body itself", "another body");
    for (const Index point : selected_of(body, tie.points, where))
      changes_.ties.push_back({point, to, tie.stiffness});
  }
  void load(const StageLoads& loads, const std::string& where) {
    const Index body = present(loads.body, where + ".body");
    if (at(rigid_, body) != 0)
      fail(where + ".body", "the rigid body '" + loads.body + "'", "a body that deforms");
    const Index first = at(bodies_.bodies(), body).points.begin;
    BodyLoads of_body{.body = body, .points = {}, .surfaces = {}};
    for (std::size_t l = 0; l < loads.loads.size(); ++l) {
      const Load& load = loads.loads[l];
      const std::string path = element_path(where + ".loads", l);
      std::vector<Index> points = selected_of(body, load.points, path);
      if (load.force) {
        of_body.points.push_back({std::move(points), *load.force, load.ramp.value_or(Ramp{})});
        continue;
      }
      for (Index& p : points) p -= first;
      of_body.surfaces.push_back(surface_load_of(scene_, bodies_, body, load, points, path));
    }
    changes_.fixed.loads.push_back(std::move(of_body));
  }

  /// Points of a part of a deformable body, or of all of it, as indices among all points.
  [[nodiscard]] std::vector<Index> part_of(const StageBody& part, const std::string& where) const {
    const Index body = present(part.body, where + ".body");
    if (part.part) {
      if (at(rigid_, body) != 0) {
        fail(where + ".part", "a part of the rigid body '" + part.body + "'",
             "no 'part': a rigid body moves as a whole");
      }
      return selected_of(body, part.part->points, where + ".part");
    }
    const Range range = at(bodies_.bodies(), body).points;
    std::vector<Index> points(static_cast<std::size_t>(range.size()));
    std::iota(points.begin(), points.end(), range.begin);
    return points;
  }
  [[nodiscard]] std::vector<Index> selected_of(Index body, const Selection& selection,
                                               const std::string& where) const {
    const Range range = at(bodies_.bodies(), body).points;
    const auto points = bodies_.points_rest().subspan(static_cast<std::size_t>(range.begin),
                                                      static_cast<std::size_t>(range.size()));
    std::vector<Index> indices = Selector{scene_, bodies_, body, points, "point"}(selection, where);
    for (Index& i : indices) i += range.begin;
    return indices;
  }

  const Scene& scene_;
  const Bodies& bodies_;
  std::vector<std::uint8_t> absent_;  ///< (n_bodies) 1: absent after the stages so far
  std::vector<std::uint8_t> rigid_;   ///< (n_bodies) 1: rigid after the stages so far
  const Stage* stage_ = nullptr;
  std::string path_;
  StageChanges::Changes changes_;
};

StageChanges::StageChanges(const Scene& scene, const Bodies& bodies) {
  StageReader reader(scene, bodies);
  Vec3 gravity = scene.settings.gravity;
  for (std::size_t stage = 0; stage < scene.stages.size(); ++stage) {
    changes_.push_back(reader.read(stage));
    gravity = scene.stages[stage].gravity.value_or(gravity);
    changes_.back().gravity = gravity;
  }
}

ModelChange StageChanges::at_start(std::size_t stage, const Bodies& bodies, std::span<const Vec3> positions,
                                   std::span<const Tie> ties, double time) const {
  const Changes& changes = changes_[stage];
  ModelChange change = changes.fixed;
  for (PointMove& move : change.moves)
    for (Keyframe& key : move.motion.keyframes) key.time += time;
  for (BodyLoads& loads : change.loads) {
    for (PointLoad& load : loads.points)
      for (double& moment : load.ramp.times) moment += time;
    for (SurfaceLoad& load : loads.surfaces)
      for (double& moment : load.ramp.times) moment += time;
  }
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const Index a = at(bodies.body_of_point(), ties[t].point);
    const Index b = bodies.body_of(at(bodies.tets(), ties[t].tet));
    const bool cut = std::ranges::any_of(changes.cuts, [&](const std::array<Index, 2>& pair) {
      return pair == std::array{a, b} || pair == std::array{b, a};
    });
    if (cut) change.untie.push_back(static_cast<Index>(t));
  }
  for (const WantedTie& tie : changes.ties) {
    const Index tet = nearest_tet(bodies, positions, tie.to, at(positions, tie.point));
    change.ties.push_back({tie.point, tet, tie.stiffness});
  }
  return change;
}

Vec3 StageChanges::gravity(std::size_t stage) const {
  return changes_[stage].gravity;
}

}  // namespace palpate

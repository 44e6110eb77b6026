#include "scene/load.hpp"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include <palpate/error.hpp>

#include "geometry/rotation.hpp"
#include "geometry/vector.hpp"
#include "scene/generators.hpp"
#include "scene/suggest.hpp"

namespace palpate {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

TetMesh source_mesh(const Scene& scene, const BodySource& source, const MeshReader& read_mesh) {
  return std::visit(
      Overloaded{[&](const MeshFile& file) { return read_mesh(scene.folder / file.path); },
                 [](const BoxGenerator& box) { return make_box(box.cells, box.size); },
                 [](const BallGenerator& ball) { return make_ball(ball.radius, ball.resolution); }},
      source);
}

Turn turn_of(const Rotation& rotation) {
  return rotation.quaternion ? palpate::turn_of(*rotation.quaternion)
                             : turn_about(rotation.axis, rotation.angle);
}

Vec3 place(const Transform& transform, const Turn& turn, const Vec3& point) {
  const Vec3 scaled{transform.scale.x * point.x, transform.scale.y * point.y, transform.scale.z * point.z};
  return rotated(turn, scaled) + transform.translate;
}

bool contains(const BoxSelection& box, const Vec3& p) {
  return box.lower.x <= p.x && p.x <= box.upper.x && box.lower.y <= p.y && p.y <= box.upper.y &&
         box.lower.z <= p.z && p.z <= box.upper.z;
}
bool contains(const SphereSelection& sphere, const Vec3& p) {
  return length(p - sphere.center) <= sphere.radius;
}

/// Indices of the points that a selection selects; List is the alternative that lists them.
template <class List>
std::vector<Index> selected(const std::variant<BoxSelection, SphereSelection, List>& selection,
                            std::span<const Vec3> points) {
  if (const auto* list = std::get_if<List>(&selection)) return list->indices;
  const auto* box = std::get_if<BoxSelection>(&selection);
  const auto* sphere = std::get_if<SphereSelection>(&selection);
  std::vector<Index> indices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (box != nullptr ? contains(*box, points[i]) : contains(*sphere, points[i])) {
      indices.push_back(static_cast<Index>(i));
    }
  }
  return indices;
}

/// The points of a body that a selection selects: at least one. `path` is its key path, for errors; `what`
/// they are: points, or tets by their centres.
template <class List>
std::vector<Index> checked_selection(const Scene& scene, const std::string& path, const SceneBody& body,
                                     const std::variant<BoxSelection, SphereSelection, List>& selection,
                                     std::span<const Vec3> points, const std::string& what = "point") {
  if (const auto* list = std::get_if<List>(&selection)) {
    for (std::size_t i = 0; i < list->indices.size(); ++i) {
      if (list->indices[i] >= 0 && static_cast<std::size_t>(list->indices[i]) < points.size()) continue;
      throw Error(scene.source, path + "." + what + "s[" + std::to_string(i) + "]",
                  std::to_string(list->indices[i]),
                  "a " + what + " index in [0, " + std::to_string(points.size() - 1) + "]");
    }
  }
  std::vector<Index> indices = selected(selection, points);
  if (indices.empty()) {
    throw Error(scene.source, path, "no " + what + " of '" + body.name + "'",
                "one or more " + what + "s selected");
  }
  return indices;
}

/// Gives the tets of a body's regions their materials.
void add_regions(const Scene& scene, Index body, Model& model) {
  const SceneBody& scene_body = at(scene.bodies, body);
  const Range tets = at(model.bodies.bodies(), body).tets;
  const auto rest = model.bodies.points_rest();
  std::vector<Vec3> centers;
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    const Tet& t = at(model.bodies.tets(), tet);
    centers.push_back(0.25 * ((at(rest, t[0]) + at(rest, t[1])) + (at(rest, t[2]) + at(rest, t[3]))));
  }
  for (std::size_t r = 0; r < scene_body.regions.size(); ++r) {
    const Region& region = scene_body.regions[r];
    const std::string path = "bodies[" + std::to_string(body) + "].regions[" + std::to_string(r) + "]";
    for (const Index tet : checked_selection(scene, path, scene_body, region.tets, centers, "tet"))
      at(model.material_of_tet, tets.begin + tet) = static_cast<Index>(model.materials.size());
    model.materials.push_back(region.material);
  }
}

/// Where any body has a region, each tet is told its material.
void add_all_regions(const Scene& scene, Model& model) {
  if (std::ranges::all_of(scene.bodies, [](const SceneBody& body) { return body.regions.empty(); })) return;
  for (Index body = 0; body < model.bodies.body_count(); ++body) {
    const auto end = static_cast<std::size_t>(at(model.bodies.bodies(), body).tets.end);
    model.material_of_tet.resize(end, body);
    add_regions(scene, body, model);
  }
}

Motion motion_of(const SceneMotion& scene_motion) {
  Motion motion{scene_motion.center, {}, scene_motion.interpolation};
  for (const SceneKeyframe& key : scene_motion.keyframes) {
    const Turn turn = turn_of(key.rotate);
    motion.keyframes.push_back(
        {key.time, key.translate, {turn.scalar, turn.vector.x, turn.vector.y, turn.vector.z}});
  }
  return motion;
}

/// Fills in what a model knows of the points of one body.
class BodyPoints {
 public:
  /// \param motions  (n_bodies) index of the motion of each body, or -1
  BodyPoints(const Scene& scene, std::size_t body, std::span<const Index> motions, Model& model)
      : scene_(scene),
        body_(scene.bodies[body]),
        motions_(motions),
        path_("bodies[" + std::to_string(body) + "]"),
        range_(model.bodies.bodies()[body].points),
        points_(model.bodies.points_rest().subspan(static_cast<std::size_t>(range_.begin),
                                                   static_cast<std::size_t>(range_.size()))),
        model_(model) {
    fill_rigid(at(motions, body));
    fill_fixed();
    fill_attached();
    fill_velocity();
    fill_loads();
    fill_grabs();
  }

 private:
  [[nodiscard]] std::string path(const char* key, std::size_t i) const {
    return path_ + "." + key + "[" + std::to_string(i) + "]";
  }
  void fill_rigid(Index motion) {
    for (Index p = range_.begin; p < range_.end; ++p) {
      if (is_rigid(body_)) at(model_.fixed_points, p) = 1;
      at(model_.motion_of_point, p) = motion;
    }
  }
  void fill_fixed() {
    for (std::size_t s = 0; s < body_.fixed.size(); ++s) {
      for (const Index i : checked_selection(scene_, path("fixed", s), body_, body_.fixed[s], points_)) {
        at(model_.fixed_points, range_.begin + i) = 1;
      }
    }
  }
  void fill_attached() {
    for (std::size_t a = 0; a < body_.attached.size(); ++a) {
      const auto& [to, selection] = body_.attached[a];
      const Index motion = motion_of_body(to, path("attached", a));
      check_start(to, at(model_.motions, motion), path("attached", a));
      for (const Index i : checked_selection(scene_, path("attached", a), body_, selection, points_)) {
        Index& there = at(model_.motion_of_point, range_.begin + i);
        if (there >= 0 && there != motion) {
          throw Error(scene_.source, path("attached", a),
                      "point " + std::to_string(i) + ", which is attached to another body too",
                      "points that follow one body");
        }
        if (at(model_.fixed_points, range_.begin + i) != 0) {
          throw Error(scene_.source, path("attached", a), "point " + std::to_string(i) + ", which is fixed",
                      "points that are not in 'fixed' too");
        }
        there = motion;
      }
    }
  }
  /// What is attached must start where it is: a bone that starts elsewhere would tear the tissue.
  void check_start(const std::string& to, const Motion& motion, const std::string& where) const {
    const Keyframe& first = motion.keyframes.front();
    const Vec3 turned{first.quaternion[1], first.quaternion[2], first.quaternion[3]};
    if (first.translate == Vec3{} && turned == Vec3{}) return;
    throw Error(scene_.source, where + ".to", "'" + to + "', whose first keyframe is away from its placement",
                "a body whose motion starts where the body is placed");
  }
  [[nodiscard]] Index motion_of_body(const std::string& name, const std::string& where) const {
    std::vector<std::string_view> known;
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      if (at(motions_, b) < 0) continue;
      if (scene_.bodies[b].name == name) return at(motions_, b);
      known.push_back(scene_.bodies[b].name);
    }
    const std::string expected = known.empty() ? "a body with a motion (there is none)"
                                               : expected_name(name, known) + ", with a motion";
    throw Error(scene_.source, where + ".to", "'" + name + "'", expected);
  }
  void fill_velocity() {
    if (body_.velocity == Vec3{}) return;
    model_.velocities.resize(model_.bodies.points_rest().size());
    for (Index p = range_.begin; p < range_.end; ++p) at(model_.velocities, p) = body_.velocity;
  }
  void fill_loads() {
    for (std::size_t l = 0; l < body_.loads.size(); ++l) {
      const auto& [force, selection] = body_.loads[l];
      const auto indices = checked_selection(scene_, path("loads", l), body_, selection, points_);
      model_.forces.resize(model_.bodies.points_rest().size());
      for (const Index i : indices) {
        at(model_.forces, range_.begin + i) += (1.0 / static_cast<double>(indices.size())) * force;
      }
    }
  }
  void fill_grabs() {
    for (const SceneGrab& grab : body_.grabs) {
      const auto nearer = [&](const Vec3& a, const Vec3& b) {
        return squared_length(a - grab.from) < squared_length(b - grab.from);
      };
      const auto nearest = std::min_element(points_.begin(), points_.end(), nearer);
      model_.grabs.push_back(
          {range_.begin + static_cast<Index>(nearest - points_.begin()), grab.target, grab.stiffness});
    }
  }

  const Scene& scene_;
  const SceneBody& body_;
  std::span<const Index> motions_;
  std::string path_;
  Range range_;
  std::span<const Vec3> points_;
  Model& model_;
};

}  // namespace

Vec3 transformed(const Transform& transform, const Vec3& point) {
  return place(transform, turn_of(transform.rotate), point);
}

Model load_model(const Scene& scene, const MeshReader& read_mesh) {
  Model model;
  std::vector<Index> motions(scene.bodies.size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    TetMesh mesh = source_mesh(scene, body.source, read_mesh);
    const Turn turn = turn_of(body.transform.rotate);
    for (Vec3& point : mesh.points) point = place(body.transform, turn, point);
    model.bodies.add(body.name, std::move(mesh));
    model.materials.push_back(body.material.value_or(Material{}));
    model.obstacles.push_back(is_rigid(body) ? 1 : 0);
    if (!body.motion) continue;
    motions[b] = static_cast<Index>(model.motions.size());
    model.motions.push_back(motion_of(*body.motion));
  }
  add_all_regions(scene, model);
  model.fixed_points.assign(model.bodies.points_rest().size(), 0);
  model.motion_of_point.assign(model.bodies.points_rest().size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) BodyPoints(scene, b, motions, model);
  return model;
}

}  // namespace palpate

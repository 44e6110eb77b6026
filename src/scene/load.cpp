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
#include "scene/near.hpp"
#include "scene/suggest.hpp"

namespace palpate {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

std::string path_of(std::size_t body) {
  return "bodies[" + std::to_string(body) + "]";
}

/// A generated mesh. What its generator refuses is an Error in the scene, at `path` of the body.
template <class Generate>
TetMesh generated(const Scene& scene, const std::string& path, Generate&& generate) {
  try {
    return generate();
  } catch (const Error& error) {
    throw Error(scene.source, path + "." + error.source() + "." + error.where(), error.found(),
                error.expected());
  }
}

TetMesh source_mesh(const Scene& scene, std::size_t body, const MeshReader& read_mesh) {
  const std::string path = path_of(body);
  return std::visit(Overloaded{[&](const MeshFile& file) { return read_mesh(scene.folder / file.path); },
                               [&](const BoxGenerator& box) {
                                 return generated(scene, path, [&] { return make_box(box.cells, box.size); });
                               },
                               [&](const BallGenerator& ball) {
                                 return generated(scene, path,
                                                  [&] { return make_ball(ball.radius, ball.resolution); });
                               }},
                    scene.bodies[body].source);
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

/// The body of a scene with that name. Throws Error naming `where`; `self` is none that it can be.
Index body_named(const Scene& scene, const std::string& name, const std::string& where, Index self) {
  std::vector<std::string_view> known;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    if (static_cast<Index>(b) == self) continue;
    if (scene.bodies[b].name == name) return static_cast<Index>(b);
    known.push_back(scene.bodies[b].name);
  }
  throw Error(scene.source, where, "'" + name + "'",
              known.empty() ? "another body (there is none)" : expected_name(name, known) + ", another body");
}

/// Indices of the points that `holds(point)` is true for.
template <class Holds>
std::vector<Index> selected(std::span<const Vec3> points, Holds&& holds) {
  std::vector<Index> indices;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (holds(points[i])) indices.push_back(static_cast<Index>(i));
  }
  return indices;
}

/// Finds the points of a body that a selection selects, or its tets by their centres.
struct Selector {
  const Scene& scene;
  const Bodies& bodies;
  Index body;
  std::span<const Vec3> points;  ///< that are selected from
  std::string what;              ///< they are: "point" or "tet"

  /// At least one, or an Error that names `path`, the selection's key path.
  template <class... Kinds>
  std::vector<Index> operator()(const std::variant<Kinds...>& selection, const std::string& path) const {
    std::vector<Index> indices = std::visit([&](const auto& kind) { return select(kind, path); }, selection);
    if (indices.empty()) {
      throw Error(scene.source, path, "no " + what + " of '" + at(scene.bodies, body).name + "'",
                  "one or more " + what + "s selected");
    }
    return indices;
  }

 private:
  [[nodiscard]] std::vector<Index> select(const BoxSelection& box, const std::string&) const {
    return selected(points, [&](const Vec3& p) { return contains(box, p); });
  }
  [[nodiscard]] std::vector<Index> select(const SphereSelection& sphere, const std::string&) const {
    return selected(points, [&](const Vec3& p) { return contains(sphere, p); });
  }
  [[nodiscard]] std::vector<Index> select(const PointSelection& list, const std::string& path) const {
    return checked(list.indices, path);
  }
  [[nodiscard]] std::vector<Index> select(const TetSelection& list, const std::string& path) const {
    return checked(list.indices, path);
  }
  [[nodiscard]] std::vector<Index> select(const NearSelection& near, const std::string& path) const {
    const Index other = body_named(scene, near.body, path + ".near.body", body);
    return selected(points, [&](const Vec3& p) {
      return (!near.box || contains(*near.box, p)) && is_near(bodies, other, p, near.distance);
    });
  }
  [[nodiscard]] std::vector<Index> checked(const std::vector<Index>& indices, const std::string& path) const {
    for (std::size_t i = 0; i < indices.size(); ++i) {
      if (indices[i] >= 0 && static_cast<std::size_t>(indices[i]) < points.size()) continue;
      throw Error(scene.source, path + "." + what + "s[" + std::to_string(i) + "]",
                  std::to_string(indices[i]),
                  "a " + what + " index in [0, " + std::to_string(points.size() - 1) + "]");
    }
    return indices;
  }
};

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
  const Selector select{scene, model.bodies, body, centers, "tet"};
  for (std::size_t r = 0; r < scene_body.regions.size(); ++r) {
    const Region& region = scene_body.regions[r];
    const std::string path = path_of(static_cast<std::size_t>(body)) + ".regions[" + std::to_string(r) + "]";
    for (const Index tet : select(region.tets, path))
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

/// Of rigid bodies that name none: its density counts, as their mass.
Material default_material(const Units& units) {
  Material material;
  material.young_modulus = from_si(material.young_modulus, units, dimension::pressure);
  material.density = from_si(material.density, units, dimension::density);
  return material;
}

/// Fills in what a model knows of the points of one body.
class BodyPoints {
 public:
  /// \param motions  (n_bodies) index of the motion of each body, or -1
  BodyPoints(const Scene& scene, std::size_t body, std::span<const Index> motions, Model& model)
      : scene_(scene),
        body_(scene.bodies[body]),
        motions_(motions),
        path_(path_of(body)),
        range_(model.bodies.bodies()[body].points),
        points_(model.bodies.points_rest().subspan(static_cast<std::size_t>(range_.begin),
                                                   static_cast<std::size_t>(range_.size()))),
        select_{scene, model.bodies, static_cast<Index>(body), points_, "point"},
        model_(model) {
    fill_rigid(at(motions, body));
    fill_fixed();
    fill_attached();
    fill_velocity();
    fill_loads();
    fill_gravity();
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
      for (const Index i : select_(body_.fixed[s], path("fixed", s))) {
        at(model_.fixed_points, range_.begin + i) = 1;
      }
    }
  }
  void fill_attached() {
    for (std::size_t a = 0; a < body_.attached.size(); ++a) {
      const Attachment& attachment = body_.attached[a];
      const std::string where = path("attached", a);
      const Index other = body_named(scene_, attachment.to, where + ".to", select_.body);
      const std::vector<Index> indices = select_(attachment.points, where);
      if (is_rigid(at(scene_.bodies, other))) {
        glue(attachment, other, indices, where);
      } else {
        tie(attachment, other, indices);
      }
    }
  }
  /// To a rigid body: the points follow its motion, or stay.
  void glue(const Attachment& attachment, Index other, const std::vector<Index>& indices,
            const std::string& where) {
    const Index motion = at(motions_, other);
    if (attachment.stiffness) {
      throw Error(scene_.source, where + ".stiffness", "it for a rigid body",
                  "nothing: the points are glued to it");
    }
    if (motion >= 0) check_start(attachment.to, at(model_.motions, motion), where);
    for (const Index i : indices) {
      Index& there = at(model_.motion_of_point, range_.begin + i);
      std::uint8_t& fixed = at(model_.fixed_points, range_.begin + i);
      if (there >= 0 && there != motion) {
        throw Error(scene_.source, where,
                    "point " + std::to_string(i) + ", which is attached to another body too",
                    "points that follow one body");
      }
      if (fixed != 0 && motion >= 0) {
        throw Error(scene_.source, where, "point " + std::to_string(i) + ", which is fixed",
                    "points that are not in 'fixed' too");
      }
      if (motion < 0) fixed = 1;
      there = motion;
    }
  }
  void tie(const Attachment& attachment, Index other, const std::vector<Index>& indices) {
    for (const Index i : indices) {
      const Index tet = nearest_tet(model_.bodies, other, at(points_, i));
      model_.ties.push_back({range_.begin + i, tet, attachment.stiffness});
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
  void fill_velocity() {
    if (body_.velocity == Vec3{} && body_.angular_velocity == Vec3{}) return;
    model_.velocities.resize(model_.bodies.points_rest().size());
    const Vec3 center = body_.angular_velocity == Vec3{} ? Vec3{} : center_of_mass();
    for (Index p = range_.begin; p < range_.end; ++p) {
      const Vec3 arm = at(model_.bodies.points_rest(), p) - center;
      at(model_.velocities, p) = body_.velocity + cross(body_.angular_velocity, arm);
    }
  }
  /// At the start, of the body's tets with their densities.
  [[nodiscard]] Vec3 center_of_mass() const {
    const auto rest = model_.bodies.points_rest();
    Vec3 sum;
    double mass = 0.0;
    const Range tets = at(model_.bodies.bodies(), select_.body).tets;
    for (Index t = tets.begin; t < tets.end; ++t) {
      const Tet& corners = at(model_.bodies.tets(), t);
      const auto corner = [&](std::size_t i) { return at(rest, corners[i]); };
      const double volume = dot(cross(corner(1) - corner(0), corner(2) - corner(0)), corner(3) - corner(0));
      const Index material = model_.material_of_tet.empty() ? select_.body : at(model_.material_of_tet, t);
      const double weight = volume * at(model_.materials, material).density;
      mass += weight;
      for (std::size_t i = 0; i < 4; ++i) sum += (0.25 * weight) * corner(i);
    }
    return (1.0 / mass) * sum;
  }
  void fill_loads() {
    for (std::size_t l = 0; l < body_.loads.size(); ++l) {
      const Load& load = body_.loads[l];
      std::vector<Index> indices = select_(load.points, path("loads", l));
      if (load.force) {
        add_force(load, std::move(indices));
      } else {
        add_surface_load(load, indices, path("loads", l));
      }
    }
  }
  void add_force(const Load& load, std::vector<Index> indices) {
    if (load.ramp) {
      for (Index& i : indices) i += range_.begin;
      model_.point_loads.push_back({std::move(indices), *load.force, *load.ramp});
      return;
    }
    model_.forces.resize(model_.bodies.points_rest().size());
    for (const Index i : indices)
      at(model_.forces, range_.begin + i) += (1.0 / static_cast<double>(indices.size())) * *load.force;
  }
  void add_surface_load(const Load& load, const std::vector<Index>& indices, const std::string& where) {
    std::vector<std::uint8_t> chosen(points_.size(), 0);
    for (const Index i : indices) at(chosen, i) = 1;
    SurfaceLoad surface{.triangles = {},
                        .pressure = load.pressure.value_or(0.0),
                        .traction = load.traction.value_or(Vec3{}),
                        .ramp = load.ramp.value_or(Ramp{})};
    const Range triangles = at(model_.bodies.bodies(), select_.body).triangles;
    for (Index t = triangles.begin; t < triangles.end; ++t) {
      const Triangle& corners = at(model_.bodies.triangles(), t);
      if (std::ranges::all_of(corners, [&](Index p) { return at(chosen, p - range_.begin) != 0; }))
        surface.triangles.push_back(t);
    }
    if (surface.triangles.empty()) {
      throw Error(scene_.source, where, "no surface triangle with all of its corners",
                  "one or more triangles selected");
    }
    model_.surface_loads.push_back(std::move(surface));
  }
  void fill_gravity() {
    if (!body_.gravity) return;
    model_.gravity_of_body.resize(scene_.bodies.size());
    at(model_.gravity_of_body, select_.body) = body_.gravity;
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
  Selector select_;
  Model& model_;
};

}  // namespace

Vec3 transformed(const Transform& transform, const Vec3& point) {
  return place(transform, turn_of(transform.rotate), point);
}

void add_body(const Scene& scene, std::size_t b, TetMesh mesh, Model& model) {
  try {
    model.bodies.add(scene.bodies[b].name, std::move(mesh));
  } catch (const Error& error) {
    throw Error(scene.source, path_of(b) + " '" + error.source() + "', " + error.where(), error.found(),
                error.expected());
  }
}

Model load_model(const Scene& scene, const MeshReader& read_mesh) {
  Model model;
  std::vector<Index> motions(scene.bodies.size(), -1);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    TetMesh mesh = source_mesh(scene, b, read_mesh);
    const Turn turn = turn_of(body.transform.rotate);
    for (Vec3& point : mesh.points) point = place(body.transform, turn, point);
    add_body(scene, b, std::move(mesh), model);
    model.materials.push_back(body.material.value_or(default_material(scene.units)));
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

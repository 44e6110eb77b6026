#include "scene/body_points.hpp"

#include <algorithm>
#include <limits>
#include <ranges>
#include <string>
#include <utility>
#include <vector>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "mesh/unused_points.hpp"
#include "scene/near.hpp"
#include "scene/scene_motion.hpp"
#include "scene/selector.hpp"
#include "scene/surface_load.hpp"

namespace palpate {
namespace {

constexpr std::uint8_t every_axis = 7;

/// Converts "xz" to the bits of Model::fixed_axes.
std::uint8_t axes_of(const std::string& names) {
  unsigned axes = 0;
  for (const char name : names) axes |= 1U << static_cast<unsigned>(name - 'x');
  return static_cast<std::uint8_t>(axes);
}

/// Fills in the data of a model on the points of one body.
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
    fill_prescribed();
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
      const Fixation& fixation = body_.fixed[s];
      const std::uint8_t axes = axes_of(fixation.axes);
      const bool whole = axes == every_axis;
      if (!whole) model_.fixed_axes.resize(model_.bodies.points_rest().size());
      for (const Index i : select_(fixation.points, path("fixed", s))) {
        if (whole) {
          at(model_.fixed_points, range_.begin + i) = 1;
        } else {
          at(model_.fixed_axes, range_.begin + i) |= axes;
        }
      }
    }
  }
  /// Adds prescribed motions of points, after those of bodies.
  void fill_prescribed() {
    for (std::size_t s = 0; s < body_.prescribed.size(); ++s) {
      const Prescription& prescription = body_.prescribed[s];
      const std::string where = path("prescribed", s);
      const auto motion = static_cast<Index>(model_.motions.size());
      for (const Index i : select_(prescription.points, where)) {
        Index& there = at(model_.motion_of_point, range_.begin + i);
        const bool has_axes = !model_.fixed_axes.empty() && at(model_.fixed_axes, range_.begin + i) != 0;
        if (there >= 0 || has_axes || at(model_.fixed_points, range_.begin + i) != 0) {
          throw Error(scene_.source, where,
                      "point " + std::to_string(i) +
                          (there >= 0 ? ", which follows another motion"
                           : has_axes ? ", which is fixed along an axis"
                                      : ", which is fixed"),
                      "points that are not fixed and follow no other motion");
        }
        there = motion;
      }
      model_.motions.push_back(motion_of(prescription.motion));
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
  /// Attaches points to a rigid body: they follow its motion, or stay.
  void glue(const Attachment& attachment, Index other, const std::vector<Index>& indices,
            const std::string& where) {
    const Index motion = at(motions_, other);
    if (attachment.stiffness) {
      throw Error(scene_.source, where + ".stiffness", "a stiffness, although 'to' is a rigid body",
                  "no stiffness: points are glued to a rigid body");
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
      const Index tet = nearest_tet(model_.bodies, model_.bodies.points_rest(), other, at(points_, i));
      model_.ties.push_back({range_.begin + i, tet, attachment.stiffness});
    }
  }
  /// Throws Error if the motion does not start where the body is placed: a bone that starts elsewhere would
  /// tear the tissue.
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
  /// Centre of mass at the start, of the body's tets with their densities.
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
        model_.surface_loads.push_back(
            surface_load_of(scene_, model_.bodies, select_.body, load, indices, path("loads", l)));
      }
    }
  }
  void add_force(const Load& load, std::vector<Index> indices) {
    for (Index& i : indices) i += range_.begin;
    model_.point_loads.push_back({std::move(indices), *load.force, load.ramp.value_or(Ramp{})});
  }
  void fill_gravity() {
    if (!body_.gravity) return;
    model_.gravity_of_body.resize(scene_.bodies.size());
    at(model_.gravity_of_body, select_.body) = body_.gravity;
  }
  void fill_grabs() {
    for (const SceneGrab& grab : body_.grabs) {
      const auto distance = [&](Index p) {
        return is_unused(model_.bodies, p) ? std::numeric_limits<double>::infinity()
                                           : squared_length(at(points_, p - range_.begin) - grab.from);
      };
      const auto points = std::views::iota(range_.begin, range_.end);
      model_.grabs.push_back({*std::ranges::min_element(points, {}, distance), grab.target, grab.stiffness});
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

void fill_points(const Scene& scene, std::size_t body, std::span<const Index> motions, Model& model) {
  BodyPoints(scene, body, motions, model);
}

}  // namespace palpate

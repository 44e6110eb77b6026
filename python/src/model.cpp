#include "model.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <palpate/error.hpp>
#include <palpate/fibres.hpp>
#include <palpate/io/cell_vectors.hpp>
#include <palpate/io/mesh_reader.hpp>

#include "geometry/vector.hpp"
#include "scene/load.hpp"
#include "scene/near.hpp"
#include "sim/prescribed_motions.hpp"
#include "world.hpp"

namespace palpate::python {

TetMesh read_checked_mesh(const std::string& path) {
  TetMesh mesh = io::read_mesh(path).mesh;
  check_mesh(mesh, path);
  return mesh;
}

Model::Model(const Scene& scene)
    : data_(load_model(
          scene, [](const std::filesystem::path& path) { return read_checked_mesh(path.string()); },
          io::read_cell_data)),
      self_collision_(scene.settings.detection.self_collision),
      reoriented_(data_.bodies.tets().size()),
      units_(scene.units) {}

const Body& Model::body_at(Index body, const char* what) const {
  if (body < 0 || body >= data_.bodies.body_count()) {
    throw Error(what, "body", std::to_string(body), "0 to " + std::to_string(data_.bodies.body_count() - 1));
  }
  return at(data_.bodies.bodies(), body);
}

bool Model::is_rigid(Index body) const {
  return at(data_.obstacles, body) != 0;
}

Index Model::point_at(const Body& body, Index point, const char* what) const {
  if (point < 0 || point >= body.points.size()) {
    throw Error(what, "point", std::to_string(point), "0 to " + std::to_string(body.points.size() - 1));
  }
  return body.points.begin + point;
}

Index Model::add_body(TetMesh mesh, BodyOptions options) {
  const bool rigid = options.obstacle || options.motion;
  const std::vector<Tet> given = mesh.tets;
  const std::size_t n_points = mesh.points.size();
  if (!options.fixed.empty() && options.fixed.size() != n_points) {
    throw Error("Model.add_body", "fixed", std::to_string(options.fixed.size()) + " flags",
                std::to_string(n_points));
  }
  check_name(data_.bodies, options.name, "Model.add_body");
  if (!rigid && !options.material) {
    throw Error("Model.add_body", "material", "none",
                "the material of a body that is neither an obstacle nor has a motion");
  }
  const Index body = data_.bodies.add(std::move(options.name), std::move(mesh));
  const Index before = body;  // materials of bodies, then those of regions
  for (Index& material : data_.material_of_tet) material += material >= before ? 1 : 0;
  data_.materials.insert(data_.materials.begin() + before, options.material.value_or(Material{}));
  if (!data_.material_of_tet.empty()) data_.material_of_tet.resize(data_.bodies.tets().size(), body);
  if (!data_.fibre_of_tet.empty()) data_.fibre_of_tet.resize(data_.bodies.tets().size());
  data_.obstacles.push_back(rigid ? 1 : 0);
  self_collision_.push_back(options.self_collision ? 1 : 0);
  const std::vector<std::uint8_t> flags = reoriented_tets(given, data_.bodies, body);
  reoriented_.insert(reoriented_.end(), flags.begin(), flags.end());

  const std::size_t all = data_.bodies.points_rest().size();
  data_.fixed_points.resize(all, rigid ? 1 : 0);
  fix(options.fixed, all);
  data_.motion_of_point.resize(all, options.motion ? static_cast<Index>(data_.motions.size()) : -1);
  if (options.motion) data_.motions.push_back(std::move(*options.motion));
  if (!data_.forces.empty()) data_.forces.resize(all);
  if (!data_.gravity_of_body.empty()) data_.gravity_of_body.resize(data_.bodies.bodies().size());
  if (!data_.velocities.empty() || options.velocity != Vec3{}) {
    data_.velocities.resize(all - n_points);
    data_.velocities.resize(all, options.velocity);
  }
  return body;
}

/// Fixes points of the last body.
void Model::fix(std::span<const std::uint8_t> axes, std::size_t all) {
  constexpr std::uint8_t every_axis = 7;
  const bool some = std::ranges::any_of(axes, [](std::uint8_t a) { return a != 0 && a != every_axis; });
  if (some || !data_.fixed_axes.empty()) data_.fixed_axes.resize(all, 0);
  for (std::size_t p = 0; p < axes.size(); ++p) {
    const std::size_t point = all - axes.size() + p;
    if (axes[p] == every_axis) {
      data_.fixed_points[point] = 1;
    } else if (axes[p] != 0) {
      data_.fixed_axes[point] = axes[p];
    }
  }
}

void Model::add_region(Index body, std::span<const Index> tets, const Material& material) {
  const Range range = body_at(body, "Model.add_region").tets;
  for (const Index tet : tets) {
    if (tet >= 0 && tet < range.size()) continue;
    throw Error("Model.add_region", "tets", std::to_string(tet), "0 to " + std::to_string(range.size() - 1));
  }
  if (data_.material_of_tet.empty()) {
    for (const Tet& tet : data_.bodies.tets()) data_.material_of_tet.push_back(data_.bodies.body_of(tet));
  }
  for (const Index tet : tets) {
    at(data_.material_of_tet, range.begin + tet) = static_cast<Index>(data_.materials.size());
  }
  data_.materials.push_back(material);
}

void Model::set_fibres(Index body, std::span<const Vec3> directions) {
  const Range range = body_at(body, "Model.set_fibres").tets;
  if (directions.size() != static_cast<std::size_t>(range.size())) {
    throw Error("Model.set_fibres", "directions", std::to_string(directions.size()) + " rows",
                std::to_string(range.size()) + ", one for each tet of the body");
  }
  data_.fibre_of_tet.resize(data_.bodies.tets().size());
  std::ranges::copy(directions, data_.fibre_of_tet.begin() + range.begin);
}

void Model::set_fibres_between(Index body, std::span<const Index> start, std::span<const Index> end) {
  set_fibres(body, fibres_between(data_.bodies, body, start, end));
}

void Model::attach(Index body, std::span<const Index> points, Index to, std::optional<double> stiffness) {
  const Body& tissue = body_at(body, "Model.attach");
  const Body& bone = body_at(to, "Model.attach");
  if (at(data_.obstacles, to) == 0) return tie(tissue, points, to, stiffness);
  const Index motion = at(data_.motion_of_point, bone.points.begin);
  if (motion < 0) {
    throw Error("Model.attach", "to", "body " + std::to_string(to) + ", which is rigid and has no motion",
                "a body with a motion, or one that deforms");
  }
  if (stiffness) {
    throw Error("Model.attach", "stiffness", "a stiffness, although the other body is rigid",
                "None: points are glued to a rigid body");
  }
  follow(tissue, points, motion, "Model.attach");
}

/// Ties points to the nearest tets.
void Model::tie(const Body& tissue, std::span<const Index> points, Index to,
                std::optional<double> stiffness) {
  if (tissue.points.begin == at(data_.bodies.bodies(), to).points.begin)
    throw Error("Model.attach", "to", "the body itself", "another body");
  for (const Index point : points) static_cast<void>(point_at(tissue, point, "Model.attach"));
  for (const Index point : points) {
    const Index p = tissue.points.begin + point;
    data_.ties.push_back(
        {p, nearest_tet(data_.bodies, data_.bodies.points_rest(), to, at(data_.bodies.points_rest(), p)),
         stiffness});
  }
}

void Model::follow(const Body& tissue, std::span<const Index> points, Index motion, const char* what) {
  for (const Index point : points) {
    const Index p = point_at(tissue, point, what);
    const bool has_axes = !data_.fixed_axes.empty() && at(data_.fixed_axes, p) != 0;
    if (at(data_.fixed_points, p) != 0 || has_axes) {
      throw Error(what, "points",
                  "point " + std::to_string(point) + ", which is fixed" + (has_axes ? " along an axis" : ""),
                  "points that can move");
    }
    if (at(data_.motion_of_point, p) >= 0 && at(data_.motion_of_point, p) != motion) {
      throw Error(what, "points", "point " + std::to_string(point) + ", which follows another body",
                  "points that follow one body");
    }
  }
  for (const Index point : points) at(data_.motion_of_point, tissue.points.begin + point) = motion;
}

Index Model::prescribe(Index body, std::span<const Index> points, Motion motion) {
  const Body& tissue = body_at(body, "Model.prescribe");
  const auto number = static_cast<Index>(data_.motions.size());
  follow(tissue, points, number, "Model.prescribe");
  data_.motions.push_back(std::move(motion));
  return number;
}

void Model::load(Index body, std::span<const Index> points, const Vec3& force, std::optional<Ramp> ramp) {
  const Body& loaded = body_at(body, "Model.load");
  if (points.empty()) throw Error("Model.load", "points", "none", "at least one");
  for (const Index point : points) static_cast<void>(point_at(loaded, point, "Model.load"));
  PointLoad load{.points = {}, .force = force, .ramp = std::move(ramp).value_or(Ramp{})};
  for (const Index point : points) load.points.push_back(loaded.points.begin + point);
  data_.point_loads.push_back(std::move(load));
}

void Model::load_surface(Index body, std::span<const Index> points, SurfaceLoad load) {
  const Body& loaded = body_at(body, "Model.load_surface");
  if (!std::isfinite(load.pressure))
    throw Error("Model.load_surface", "pressure", std::to_string(load.pressure), "a finite number");
  std::vector<std::uint8_t> chosen(static_cast<std::size_t>(loaded.points.size()), 0);
  for (const Index point : points) {
    static_cast<void>(point_at(loaded, point, "Model.load_surface"));
    at(chosen, point) = 1;
  }
  for (Index t = loaded.triangles.begin; t < loaded.triangles.end; ++t) {
    const Triangle& corners = at(data_.bodies.triangles(), t);
    if (std::ranges::all_of(corners, [&](Index p) { return at(chosen, p - loaded.points.begin) != 0; }))
      load.triangles.push_back(t);
  }
  if (load.triangles.empty()) {
    throw Error("Model.load_surface", "points", "no surface triangle with all of its corners",
                "points of one or more triangles");
  }
  data_.surface_loads.push_back(std::move(load));
}

void Model::set_velocities(Index body, std::span<const Vec3> velocities) {
  const Range range = body_at(body, "Model").points;
  data_.velocities.resize(data_.bodies.points_rest().size());
  for (Index p = 0; p < range.size(); ++p) at(data_.velocities, range.begin + p) = at(velocities, p);
}

void Model::set_gravity(Index body, const Vec3& gravity) {
  static_cast<void>(body_at(body, "Model"));
  data_.gravity_of_body.resize(data_.bodies.bodies().size());
  at(data_.gravity_of_body, body) = gravity;
}

void Model::grab(Index body, Index point, const Vec3& target, double stiffness) {
  data_.grabs.push_back({point_at(body_at(body, "Model.grab"), point, "Model.grab"), target, stiffness});
}

std::vector<Vec3> Model::start_positions() const {
  const std::span<const Vec3> rest = data_.bodies.points_rest();
  return PrescribedMotions(data_.motions, data_.motion_of_point, rest)
      .start_positions(parallel::Threads(1), rest);
}

}  // namespace palpate::python

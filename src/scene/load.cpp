#include "scene/load.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <variant>

#include <palpate/error.hpp>

#include "geometry/vector.hpp"
#include "scene/generators.hpp"

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

/// A unit quaternion: scalar part and vector part.
struct Turn {
  double scalar;
  Vec3 vector;
};

Turn turn_of(const Rotation& rotation) {
  if (rotation.quaternion) {
    const auto& [w, x, y, z] = *rotation.quaternion;
    const double norm = std::hypot(w, length({x, y, z}));
    return {w / norm, (1.0 / norm) * Vec3{x, y, z}};
  }
  const double half = 0.5 * rotation.angle * std::numbers::pi / 180.0;
  return {std::cos(half), std::sin(half) * normalized(rotation.axis)};
}

Vec3 place(const Transform& transform, const Turn& turn, const Vec3& point) {
  const Vec3 scaled{transform.scale.x * point.x, transform.scale.y * point.y, transform.scale.z * point.z};
  const Vec3 t = 2.0 * cross(turn.vector, scaled);
  return scaled + turn.scalar * t + cross(turn.vector, t) + transform.translate;
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

void check_indices(const Scene& scene, const std::string& path, const char* what,
                   std::span<const Index> indices, Index count) {
  for (std::size_t i = 0; i < indices.size(); ++i) {
    if (indices[i] >= 0 && indices[i] < count) continue;
    throw Error(scene.source, path + "." + what + "s[" + std::to_string(i) + "]", std::to_string(indices[i]),
                "a " + std::string(what) + " index in [0, " + std::to_string(count - 1) + "]");
  }
}

void require_one(const Scene& scene, std::size_t body, const std::string& path, const char* what,
                 std::span<const Index> selected) {
  if (!selected.empty()) return;
  throw Error(scene.source, path, "no " + std::string(what) + " of '" + scene.bodies[body].name + "'",
              "one or more " + std::string(what) + "s selected");
}

std::vector<std::uint8_t> fixed_points(const Scene& scene, std::size_t body, std::span<const Vec3> points) {
  std::vector<std::uint8_t> fixed(points.size(), scene.bodies[body].obstacle ? 1 : 0);
  const auto& selections = scene.bodies[body].fixed;
  for (std::size_t s = 0; s < selections.size(); ++s) {
    const std::string path = "bodies[" + std::to_string(body) + "].fixed[" + std::to_string(s) + "]";
    if (const auto* list = std::get_if<PointSelection>(&selections[s]))
      check_indices(scene, path, "point", list->indices, static_cast<Index>(points.size()));
    const auto indices = selected<PointSelection>(selections[s], points);
    require_one(scene, body, path, "point", indices);
    for (const Index i : indices) at(fixed, i) = 1;
  }
  return fixed;
}

/// Gives the tets of a body's regions their materials; the body is placed.
void add_regions(const Scene& scene, const Bodies& bodies, Index body, LoadedScene& loaded) {
  const auto& regions = at(scene.bodies, body).regions;
  const Range tets = at(bodies.bodies(), body).tets;
  const auto rest = bodies.points_rest();
  std::vector<Vec3> centers;
  for (Index tet = tets.begin; tet < tets.end; ++tet) {
    const Tet& t = at(bodies.tets(), tet);
    centers.push_back(0.25 * ((at(rest, t[0]) + at(rest, t[1])) + (at(rest, t[2]) + at(rest, t[3]))));
  }
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const std::string path = "bodies[" + std::to_string(body) + "].regions[" + std::to_string(r) + "]";
    if (const auto* list = std::get_if<TetSelection>(&regions[r].tets))
      check_indices(scene, path, "tet", list->indices, tets.size());
    const auto own_tets = selected<TetSelection>(regions[r].tets, centers);
    require_one(scene, static_cast<std::size_t>(body), path, "tet", own_tets);
    for (const Index tet : own_tets)
      at(loaded.material_of_tet, tets.begin + tet) = static_cast<Index>(loaded.materials.size());
    loaded.materials.push_back(regions[r].material);
  }
}

/// Bodies without a region anywhere need no list of tets.
bool has_regions(const Scene& scene) {
  return std::ranges::any_of(scene.bodies, [](const SceneBody& body) { return !body.regions.empty(); });
}

}  // namespace

Vec3 transformed(const Transform& transform, const Vec3& point) {
  return place(transform, turn_of(transform.rotate), point);
}

LoadedScene load_bodies(const Scene& scene, const MeshReader& read_mesh) {
  LoadedScene loaded;
  const bool by_tet = has_regions(scene);
  for (const SceneBody& body : scene.bodies) loaded.materials.push_back(body.material.value_or(Material{}));
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const SceneBody& body = scene.bodies[b];
    TetMesh mesh = source_mesh(scene, body.source, read_mesh);
    const Turn turn = turn_of(body.transform.rotate);
    for (Vec3& point : mesh.points) point = place(body.transform, turn, point);
    const auto fixed = fixed_points(scene, b, mesh.points);
    const Index index = loaded.bodies.add(body.name, std::move(mesh));
    loaded.fixed.insert(loaded.fixed.end(), fixed.begin(), fixed.end());
    loaded.obstacle.push_back(body.obstacle);
    if (!by_tet) continue;
    loaded.material_of_tet.resize(loaded.bodies.tets().size(), index);
    add_regions(scene, loaded.bodies, index, loaded);
  }
  return loaded;
}

}  // namespace palpate

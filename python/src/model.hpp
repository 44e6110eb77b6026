#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <palpate/model.hpp>

#include "scene/scene.hpp"

namespace palpate::python {

/// The properties of a body without its mesh.
struct BodyOptions {
  std::string name;
  std::optional<Material> material;
  Vec3 velocity{};
  std::vector<std::uint8_t> fixed;  ///< (n_points) axes, as in Model::fixed_axes; or empty
  bool obstacle = false;
  bool self_collision = false;
  std::optional<Motion> motion;
};

/// The model of a simulation: bodies, materials, constraints, motions and loads.
class Model {
 public:
  Model() = default;
  /// The model of a scene; reads its mesh files.
  explicit Model(const Scene& scene);

  Index add_body(TetMesh mesh, BodyOptions options);
  void add_region(Index body, std::span<const Index> tets, const Material& material);
  /// Sets directions of fibres (n_tets of the body x 3), which replace those of the materials; zero: that of
  /// the material.
  void set_fibres(Index body, std::span<const Vec3> directions);
  /// Sets directions of fibres by fibres_between().
  void set_fibres_between(Index body, std::span<const Index> start, std::span<const Index> end);
  /// Attaches points to a body with a motion, or by springs to a deformable body.
  void attach(Index body, std::span<const Index> points, Index to, std::optional<double> stiffness);
  /// Returns the number of the motion.
  Index prescribe(Index body, std::span<const Index> points, Motion motion);
  void load(Index body, std::span<const Index> points, const Vec3& force, std::optional<Ramp> ramp);
  /// Loads the surface triangles with all corners among the points.
  void load_surface(Index body, std::span<const Index> points, SurfaceLoad load);
  void set_velocities(Index body, std::span<const Vec3> velocities);
  void set_gravity(Index body, const Vec3& gravity);
  void grab(Index body, Index point, const Vec3& target, double stiffness);

  /// Positions at time 0 (n_points x 3), m: at rest, prescribed ones at the pose of their motion.
  [[nodiscard]] std::vector<Vec3> start_positions() const;
  [[nodiscard]] const palpate::Model& data() const { return data_; }
  [[nodiscard]] bool is_rigid(Index body) const;
  /// (n_bodies) 1 for bodies with self-collision.
  [[nodiscard]] const std::vector<std::uint8_t>& self_collision() const { return self_collision_; }
  /// (n_tets) 1: reoriented: two corners were swapped relative to the input mesh.
  [[nodiscard]] const std::vector<std::uint8_t>& reoriented() const { return reoriented_; }
  /// Those of the scene that it was made of; none for a model built in code.
  [[nodiscard]] const std::optional<Units>& units() const { return units_; }

 private:
  void tie(const Body& tissue, std::span<const Index> points, Index to, std::optional<double> stiffness);
  void fix(std::span<const std::uint8_t> axes, std::size_t all);
  void follow(const Body& tissue, std::span<const Index> points, Index motion, const char* what);
  [[nodiscard]] const Body& body_at(Index body, const char* what) const;
  [[nodiscard]] Index point_at(const Body& body, Index point, const char* what) const;

  palpate::Model data_;
  std::vector<std::uint8_t> self_collision_;
  std::vector<std::uint8_t> reoriented_;
  std::optional<Units> units_;
};

/// Reads the tets of a mesh file and checks them; errors name the file.
TetMesh read_checked_mesh(const std::string& path);

}  // namespace palpate::python

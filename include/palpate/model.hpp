#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate {

/// The pose of a rigid motion at a time: a point p of the start is at center + R (p - center) + translate.
struct Keyframe {
  double time = 0.0;                                     ///< s
  Vec3 translate{};                                      ///< m
  std::array<double, 4> quaternion{1.0, 0.0, 0.0, 0.0};  ///< of R: (w, x, y, z), any length but zero
};

/// Interpolation of a motion between keyframes.
enum class Interpolation {
  linear,  ///< at constant speed, so the speed is discontinuous at keyframes
  smooth   ///< starting and ending at rest: the fraction s of the time between becomes s^2 (3 - 2 s)
};
/// Names of Interpolation; index = enum value.
inline constexpr std::array<std::string_view, 2> interpolation_names{"linear", "smooth"};

/// A prescribed rigid motion: keyframes with ascending times. Rotations take the shorter arc, at constant
/// angular speed for a constant fraction (slerp: Shoemake, "Animating rotation with quaternion curves",
/// SIGGRAPH 1985). Before the first keyframe and after the last the pose is constant.
struct Motion {
  Vec3 center{};                                        ///< of the rotation, m
  std::vector<Keyframe> keyframes;                      ///< one or more, with ascending times
  Interpolation interpolation = Interpolation::linear;  ///< between keyframes
};

/// The pose of a motion at a time (s); the quaternion has length 1. Throws Error on a motion that a
/// Simulation would refuse. O(keyframes).
Keyframe pose_at(const Motion& motion, double time);

/// A spring between a point and a position in space, force = stiffness (target - point).
struct Grab {
  Index point = -1;        ///< of all points
  Vec3 target{};           ///< m
  double stiffness = 0.0;  ///< N/m, > 0
};

/// A spring between a point and its position at the start in a tet of another body: tissue that has grown
/// together. If it is at least as stiff as a contact, the point does not touch that body, nor do tets, edges
/// and triangles with the point. relax() runs before the start and ignores ties.
struct Tie {
  Index point = -1;                   ///< of all points
  Index tet = -1;                     ///< usually the nearest tet; the position may be a little outside of it
  std::optional<double> stiffness{};  ///< N/m, > 0; none: that of a contact between the two bodies
};

/// A force that is distributed equally to points.
struct PointLoad {
  std::vector<Index> points{};  ///< indices among all points; a repeated one counts twice
  Vec3 force{};                 ///< N, the sum over the points
  Ramp ramp{};                  ///< factor of the force over time
};

/// A load on a part of a surface.
struct SurfaceLoad {
  std::vector<Index> triangles{};  ///< of all surface triangles, each once
  /// Pressure, Pa, against the outward normal. It follows the surface: with the normals and areas at the
  /// start of each step.
  double pressure = 0.0;
  Vec3 traction{};  ///< Pa, force per area at rest; keeps its direction
  Ramp ramp{};      ///< of both
};

/// The bodies of a simulation with materials, constraints and loads. Empty arrays mean "none", where that is
/// allowed.
struct Model {
  Bodies bodies{};  ///< the meshes at their start, at rest
  std::vector<Material>
      materials{};  ///< of each body (for an obstacle only the density matters), then others
  std::vector<Index> material_of_tet{};  ///< (n_tets) index into materials; or empty: that of its body
  /// (n_tets) directions of fibres at rest, of any length; empty, or zero for a tet: that of its material.
  std::vector<Vec3> fibre_of_tet{};
  std::vector<std::uint8_t> fixed_points{};  ///< (n_points) 1: does not move freely; or empty
  /// (n_points) axes of the world along which a point does not move, 1 (x) + 2 (y) + 4 (z), 7 is like
  /// fixed_points; for rollers and planes of symmetry; or empty. Ignored where a point is fixed or
  /// prescribed.
  std::vector<std::uint8_t> fixed_axes{};
  std::vector<std::uint8_t> obstacles{};     ///< (n_bodies) 1: rigid, no point of it is free; or empty
  std::vector<Motion> motions{};             ///< prescribed motions of obstacles and attached points
  std::vector<Index> motion_of_point{};      ///< (n_points) index into motions, or -1; or empty
  std::vector<Vec3> forces{};                ///< (n_points), N, or empty: until set_forces() replaces them
  std::vector<Vec3> velocities{};            ///< (n_points) of free points at the start, m/s; or empty
  std::vector<Grab> grabs{};                 ///< springs to positions in space, at the start
  std::vector<Tie> ties{};                   ///< springs between bodies, at rest at the start
  std::vector<PointLoad> point_loads{};      ///< in addition to `forces`
  std::vector<SurfaceLoad> surface_loads{};  ///< on deformable bodies
  /// (n_bodies) or empty: gravity of a body, m/s^2, which replaces that of the settings.
  std::vector<std::optional<Vec3>> gravity_of_body{};
  /// (n_bodies) 1: absent until a ModelChange inserts it; or empty. An absent body has no contacts and no
  /// weight, and does not move.
  std::vector<std::uint8_t> absent{};
};

/// Points that follow a motion from now on: a point now at p moves to center + R (p - center) + translate.
/// Times of the keyframes are simulation times.
struct PointMove {
  std::vector<Index> points{};  ///< of all points
  Motion motion{};              ///< the motion
};

/// Loads that replace all loads of a body: those of the model, set_forces() and set_pressure().
struct BodyLoads {
  Index body = -1;                      ///< the loaded body
  std::vector<PointLoad> points{};      ///< of points of this body
  std::vector<SurfaceLoad> surfaces{};  ///< of triangles of this body
};

/// Changes of constraints, motions and loads from the next step on: Simulation::change(). They are made in
/// this order.
struct ModelChange {
  std::vector<Index> untie{};           ///< numbers of ties to remove; later ties then get lower numbers
  std::vector<Index> insert{};          ///< bodies to insert, at their positions or the pose of their motion
  std::vector<Index> remove{};          ///< bodies to remove, with their ties
  std::vector<Index> release_bodies{};  ///< bodies whose points become free; rigid ones become deformable
  std::vector<Index> release_points{};  ///< points that are no longer fixed, moved, or held along an axis
  std::vector<Index> fix{};             ///< points of bodies that deform, to fix where they are
  std::vector<PointMove> moves{};       ///< each adds a motion; points leave their earlier one
  std::vector<Tie> ties{};              ///< appended to the existing ones, at rest at the current positions
  std::vector<BodyLoads> loads{};       ///< each body at most once
};

}  // namespace palpate

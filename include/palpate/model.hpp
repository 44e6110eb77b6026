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

/// Where a rigid motion is at a time: every point p of the start goes to center + R (p - center) + translate.
struct Keyframe {
  double time = 0.0;                                     ///< s
  Vec3 translate{};                                      ///< m
  std::array<double, 4> quaternion{1.0, 0.0, 0.0, 0.0};  ///< of R: (w, x, y, z), any length but zero
};

/// How a motion goes from one keyframe to the next.
enum class Interpolation {
  linear,  ///< at constant speed, so that the speed jumps at keyframes
  smooth   ///< starting and ending at rest: the fraction s of the time between becomes s^2 (3 - 2 s)
};
/// Names of Interpolation; index = enum value.
inline constexpr std::array<std::string_view, 2> interpolation_names{"linear", "smooth"};

/// A prescribed rigid motion: keyframes of growing times. Rotations take the shorter arc, at constant angular
/// speed for a constant fraction (slerp: Shoemake, "Animating rotation with quaternion curves", SIGGRAPH
/// 1985). Before the first keyframe and after the last the pose is constant.
struct Motion {
  Vec3 center{};                                        ///< of the rotation, m
  std::vector<Keyframe> keyframes;                      ///< one or more, of growing times
  Interpolation interpolation = Interpolation::linear;  ///< between keyframes
};

/// Where a motion is at a time (s); the quaternion has length 1. Throws Error on a motion that a Simulation
/// would refuse. O(keyframes).
Keyframe pose_at(const Motion& motion, double time);

/// A spring between a point and a place in space, force = stiffness (target - point).
struct Grab {
  Index point = -1;        ///< of all points
  Vec3 target{};           ///< m
  double stiffness = 0.0;  ///< N/m, > 0
};

/// A spring that holds a point to the place of a tet of another body where it is at the start: tissue that
/// has grown together. relax() runs before the start and ignores ties.
struct Tie {
  Index point = -1;                   ///< of all points
  Index tet = -1;                     ///< best the nearest one; the place may lie a little outside of it
  std::optional<double> stiffness{};  ///< N/m, > 0; none: that of a contact between the two bodies
};

/// A force that points share equally.
struct PointLoad {
  std::vector<Index> points{};  ///< of all points; one that is named twice counts twice
  Vec3 force{};                 ///< N, the sum over the points
  Ramp ramp{};                  ///< factor of the force over time
};

/// A load on a part of a surface.
struct SurfaceLoad {
  std::vector<Index> triangles{};  ///< of all surface triangles, each once
  /// Pa, against the outward normal. It follows the surface: normals and areas are those at the start of each
  /// step.
  double pressure = 0.0;
  Vec3 traction{};  ///< Pa, force per area at rest; keeps its direction
  Ramp ramp{};      ///< of both
};

/// What a simulation is made of, apart from its settings. Arrays that are allowed to be empty then mean
/// "none".
struct Model {
  Bodies bodies{};                    ///< the meshes at their start, at rest
  std::vector<Material> materials{};  ///< of each body (of an obstacle only the density counts), then others
  std::vector<Index> material_of_tet{};  ///< (n_tets) index into materials; or empty: that of its body
  /// (n_tets) directions of fibres at rest, of any length; empty, or zero for a tet: that of its material.
  std::vector<Vec3> fibre_of_tet{};
  std::vector<std::uint8_t> fixed_points{};  ///< (n_points) 1: does not deform freely; or empty
  /// (n_points) axes of the world along which a point does not move, 1 (x) + 2 (y) + 4 (z), 7 as
  /// fixed_points: rollers and planes of symmetry; or empty. Ignored where a point is fixed or
  /// prescribed.
  std::vector<std::uint8_t> fixed_axes{};
  std::vector<std::uint8_t> obstacles{};     ///< (n_bodies) 1: rigid, no point of it is free; or empty
  std::vector<Motion> motions{};             ///< prescribed motions of obstacles and attached points
  std::vector<Index> motion_of_point{};      ///< (n_points) index into motions, or -1; or empty
  std::vector<Vec3> forces{};                ///< (n_points) loads on points, N; or empty
  std::vector<Vec3> velocities{};            ///< (n_points) of free points at the start, m/s; or empty
  std::vector<Grab> grabs{};                 ///< springs to places in space, at the start
  std::vector<Tie> ties{};                   ///< springs between bodies, at rest at the start
  std::vector<PointLoad> point_loads{};      ///< besides `forces`
  std::vector<SurfaceLoad> surface_loads{};  ///< on bodies that deform
  /// (n_bodies) or empty: gravity of a body, m/s^2, in place of that of the settings.
  std::vector<std::optional<Vec3>> gravity_of_body{};
  /// (n_bodies) 1: not there at first, until a ModelChange brings it in; or empty. What is not there touches
  /// nothing, weighs nothing and does not move.
  std::vector<std::uint8_t> absent{};
};

/// Points that follow a motion from now on: each goes to center + R (p - center) + translate of where it is
/// now. Times of the keyframes are those of the simulation.
struct PointMove {
  std::vector<Index> points{};  ///< of all points
  Motion motion{};              ///< theirs from now on
};

/// Loads in place of all that were set on a body: those of the model, set_forces() and set_pressure().
struct BodyLoads {
  Index body = -1;                      ///< whose loads they are
  std::vector<PointLoad> points{};      ///< of points of this body
  std::vector<SurfaceLoad> surfaces{};  ///< of triangles of this body
};

/// What holds, moves and loads bodies from the next step on: Simulation::change(). In this order.
struct ModelChange {
  std::vector<Index> untie{};           ///< numbers of ties; those behind them have lower numbers then
  std::vector<Index> insert{};          ///< bodies that are there again, where they are or their motion is
  std::vector<Index> remove{};          ///< bodies that are absent from now on; their ties are removed
  std::vector<Index> release_bodies{};  ///< nothing holds their points any more; what was rigid deforms
  std::vector<Index> release_points{};  ///< neither fixed nor moved any more, nor held along an axis
  std::vector<Index> fix{};             ///< points that stay where they are
  std::vector<PointMove> moves{};       ///< each is a motion more; points leave the one they were on
  std::vector<Tie> ties{};              ///< behind those that are there, at rest where their points are now
  std::vector<BodyLoads> loads{};       ///< of bodies, each once
};

}  // namespace palpate

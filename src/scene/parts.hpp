#pragma once

#include <array>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/model.hpp>
#include <palpate/types.hpp>

/// The parts of bodies and stages in a scene, as plain data.
namespace palpate {

/// Bodies by their names.
struct BodyNames {
  std::vector<std::string> names;
};
/// A body from a mesh file; a relative path is relative to the folder of the scene file.
struct MeshFile {
  std::string path;
};
/// A box of cells[0] x cells[1] x cells[2] cells of 5 tets; see make_box().
struct BoxGenerator {
  std::array<int, 3> cells{1, 1, 1};
  Vec3 size{1.0, 1.0, 1.0};
};
/// A ball of `resolution` layers; see make_ball().
struct BallGenerator {
  double radius = 1.0;
  int resolution = 4;
};
using BodySource = std::variant<MeshFile, BoxGenerator, BallGenerator>;

/// A right-handed rotation about an axis through the origin; the quaternion (w, x, y, z), if given, replaces
/// axis and angle.
struct Rotation {
  Vec3 axis{0.0, 0.0, 1.0};  ///< any length but zero
  double angle = 0.0;        ///< degrees
  std::optional<std::array<double, 4>> quaternion{};
};

/// Places a body: first scale (per axis, about the origin), then rotate, then translate.
struct Transform {
  Vec3 scale{1.0, 1.0, 1.0};  ///< each > 0
  Rotation rotate;
  Vec3 translate{};
};

/// Selects the points in the closed box, in world coordinates of the placed body.
struct BoxSelection {
  Vec3 lower;
  Vec3 upper;
};
/// Selects the points in the closed ball, in world coordinates of the placed body.
struct SphereSelection {
  Vec3 center;
  double radius = 0.0;
};
/// Selects points by their 0-based index in the body's own mesh.
struct PointSelection {
  std::vector<Index> indices;
};
/// Selects the points within `distance` of the surface of another body, at the placement of both at the
/// start; with a box, only points in it.
struct NearSelection {
  std::string body;
  double distance = 0.0;
  std::optional<BoxSelection> box{};
};
using Selection = std::variant<BoxSelection, SphereSelection, PointSelection, NearSelection>;
/// A part of a body: the selected points.
struct PointPart {
  Selection points;
};

/// Points that do not move along some or all axes of the world.
struct Fixation {
  Selection points;
  std::string axes{"xyz"};  ///< axes along which they do not move: x, y and z, each at most once
};

/// Selects tets by their 0-based index in the body's own mesh.
struct TetSelection {
  std::vector<Index> indices;
};
/// Selects the tets with this number in the array `label` of the body's mesh file.
struct LabelSelection {
  int label = 0;
};
/// The tets of a region: by index, by label, or all whose centre (mean of the corners) is in the box or ball.
using RegionSelection = std::variant<BoxSelection, SphereSelection, TetSelection, LabelSelection>;

/// A part of a body with a material of its own.
struct Region {
  RegionSelection tets;
  Material material;
  std::optional<std::array<double, 3>> color{};  ///< red, green, blue in [0, 1]; none: that of the body
};
/// One keyframe of a motion; see Keyframe.
struct SceneKeyframe {
  double time = 0.0;
  Vec3 translate{};
  Rotation rotate;
};
/// Prescribed motion of a rigid body; see Motion.
struct SceneMotion {
  Vec3 center{};
  Interpolation interpolation = Interpolation::linear;
  std::vector<SceneKeyframe> keyframes;
};
/// Points that are attached to another body: they follow its motion, or are tied to it by springs if it
/// deforms; see Tie.
struct Attachment {
  std::string to;  ///< name of a body with a motion, or of a deformable body
  Selection points;
  std::optional<double> stiffness{};  ///< of each spring; only for a deformable body `to`
};
/// Points of a deformable body with a prescribed displacement.
struct Prescription {
  Selection points;
  SceneMotion motion;
};
/// Fibres along curves from some points of a body to others; see fibres_between().
struct FibreEnds {
  std::vector<PointPart> from;  ///< union of these selections
  std::vector<PointPart> to;    ///< union of these selections, without points of `from`
};
/// A load: one of a force on selected points, and a pressure or traction on surface triangles with all
/// corners selected.
struct Load {
  std::optional<Vec3> force{};       ///< in equal parts on the points
  std::optional<double> pressure{};  ///< against the outward normal; follows the surface
  std::optional<Vec3> traction{};    ///< per area at rest; keeps its direction
  std::optional<Ramp> ramp{};        ///< none: the full load at all times
  Selection points;
};
/// A spring between a position in space and the point of the body that is nearest to `from`.
struct SceneGrab {
  Vec3 from{};
  Vec3 target{};
  double stiffness = 0.0;
};

}  // namespace palpate

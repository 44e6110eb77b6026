#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "scene/first_scene.hpp"

namespace palpate::app {

/// The settings of the first scene of a mesh.
struct NewSceneRequest {
  std::filesystem::path mesh;
  std::filesystem::path folder{};   ///< of the scene; the path of the mesh is relative to it
  std::optional<MeshUnit> unit{};   ///< none: guessed
  std::optional<double> longest{};  ///< wanted length of the longest side, m, instead of a unit
  bool drop = false;
};

struct NewScene {
  NewSceneRequest request;
  double longest_side = 0.0;  ///< in units of the file
  MeshUnit unit;              ///< the unit that was given or guessed
  FirstScene first;
};

/// The first scene of a mesh file. Throws BadInput naming the file.
NewScene new_scene_of(const NewSceneRequest& request);

/// A line on the new scene, such as "liver.vtu in mm: 0.21 m, 1.4 kg; its lowest tenth is held, and an
/// instrument presses it".
std::string description_of(const NewScene& made);

/// A line on the unit that was guessed: "unit guessed: mm (choose with --unit)".
std::string guess_of(const NewScene& made);

/// A line on the stiffness of the body: it is chosen by the shape, not by the tissue.
std::string stiffness_of(const NewScene& made);

/// The command that writes this scene, such as "palpate new liver.vtu --unit mm".
std::string command_of(const NewScene& made);

}  // namespace palpate::app

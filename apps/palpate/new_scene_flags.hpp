#pragma once

#include <CLI/CLI.hpp>

#include "new_scene.hpp"

/// What 'new' and 'view' ask of a mesh whose file does not say what its numbers are in.
namespace palpate::app {

struct NewSceneFlags {
  NewSceneRequest request;
  bool yes = false;  ///< take the guess, do not ask
};

/// Adds --unit, --size, --drop and --yes.
void add_new_scene_flags(CLI::App& app, NewSceneFlags& flags);

/// Throws BadInput naming a flag that was given, where `found` is no mesh.
void refuse_new_scene_flags(const NewSceneFlags& flags, const std::string& found);

/// The first scene of a mesh. Asks for the unit where no flag gives it and a user can answer: stdin
/// and stderr are a terminal.
NewScene new_scene_as_agreed(const NewSceneFlags& flags);

}  // namespace palpate::app

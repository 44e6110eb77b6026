#pragma once

#include <CLI/CLI.hpp>

#include "new_scene.hpp"

/// The questions of 'new' and 'view' on a mesh file that does not name its unit.
namespace palpate::app {

struct NewSceneFlags {
  NewSceneRequest request;
  bool yes = false;  ///< use the guessed unit without asking
};

/// Adds --unit, --size, --drop and --yes.
void add_new_scene_flags(CLI::App& app, NewSceneFlags& flags);

/// Throws BadInput naming the first of these flags, if one was given.
/// \param found  what was given instead of a mesh
void refuse_new_scene_flags(const NewSceneFlags& flags, const std::string& found);

/// The first scene of a mesh. Asks for the unit where no flag gives it and a user can answer: stdin
/// and stderr are a terminal.
NewScene new_scene_as_agreed(const NewSceneFlags& flags);

}  // namespace palpate::app

#pragma once

#include <vector>

#include "subcommands.hpp"

namespace palpate::app {

/// Adds `eye`, `skull` and others to `generate`: meshes and label maps of the medical scenes.
std::vector<Subcommand> add_generate_anatomy(CLI::App& generate);

}  // namespace palpate::app

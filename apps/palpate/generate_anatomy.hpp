#pragma once

#include <vector>

#include "subcommands.hpp"

namespace palpate::app {

/// Adds `eye` and `skull` to `generate`: the organs of the medical scenes, one mesh file each.
std::vector<Subcommand> add_generate_anatomy(CLI::App& generate);

}  // namespace palpate::app

#pragma once

#include <string>

#include "steps/scene_row.hpp"

namespace palpate::bench {

/// The rows of scene_row() as a table for a terminal, and what is left out.
std::string steps_table(const Json& report);

}  // namespace palpate::bench

#pragma once

#include <string>

#include "scene/scene.hpp"

namespace palpate::app {

/// Warns, in one line, where materials of the scene are presets (material.tissue).
void warn_of_presets(const Scene& scene);

/// Text on presets for help pages: their names with Young's moduli.
std::string tissue_lines();

}  // namespace palpate::app

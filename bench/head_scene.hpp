#pragma once

#include <filesystem>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate::bench {

/// A model and how it moves.
struct HeadScene {
  Model model;
  SimulationSettings settings;
};

/// Soft tissue on bones, of which the lower jaw goes 2 mm along -y in 0.8 s; overlaps are removed.
/// \param folder  has hq_skull.mesh, hq_lower.mesh, hq_upper.mesh and hq_soft.mesh, in mm
/// Throws Error as readers do.
HeadScene head_scene(const std::filesystem::path& folder);

}  // namespace palpate::bench

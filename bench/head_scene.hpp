#pragma once

#include <filesystem>

#include <palpate/model.hpp>
#include <palpate/settings.hpp>

namespace palpate::bench {

/// A model with its settings.
struct HeadScene {
  Model model;
  SimulationSettings settings;
};

/// Soft tissue on bones, with a motion of the lower jaw by 2 mm along -y in 0.8 s; overlaps are removed.
/// \param folder  has hq_skull.mesh, hq_lower.mesh, hq_upper.mesh and hq_soft.mesh, in mm
///
/// Throws Error as readers do.
HeadScene head_scene(const std::filesystem::path& folder);

}  // namespace palpate::bench

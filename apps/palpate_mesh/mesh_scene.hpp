#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>

#include "scene/scene.hpp"

/// The scene that `palpate mesh` writes.
namespace palpate::app {

/// A first guess of the material: soft tissue between fat and muscle, in Pa and g/mm^3. Users replace it.
inline const Material first_tissue{.young_modulus = 20e3,
                                   .poisson_ratio = 0.45,
                                   .density = 1e-3,
                                   .mass_damping = 5.0,
                                   .stiffness_damping = 0.02};

/// A file name that every system accepts and that is not in `used`; adds it there.
std::string mesh_file_name(const std::string& organ, std::set<std::string>& used);

SceneBody first_body(const std::string& name, const std::string& file, bool rigid,
                     const std::optional<std::array<double, 3>>& color);

/// A scene in mm, g and s, so that stresses are in Pa; without motions and loads.
Scene first_scene(const std::string& name);

}  // namespace palpate::app

#pragma once

#include <string>

#include "scene/scene.hpp"

/// Checks of a scene that involve several keys: references to bodies, and unique names.
namespace palpate {

/// Checks that a name exists. Throws Error naming the key path and the nearest name.
void check_known(const Scene& scene, const std::string& body, const std::string& path);
void check_known(const Scene& scene, const BodyNames& bodies, const std::string& path);

/// Throws Error unless stages and outcomes have different names and refer to existing bodies.
void check_stages(const Scene& scene);
void check_outcomes(const Scene& scene);

}  // namespace palpate

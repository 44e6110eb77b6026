#pragma once

#include <string>

#include "scene/scene.hpp"

/// What a scene must be beside the values of its keys: names that are names of bodies, and names of their
/// own.
namespace palpate {

/// Throws Error naming the key path and the nearest name.
void check_known(const Scene& scene, const std::string& body, const std::string& path);
void check_known(const Scene& scene, const BodyNames& bodies, const std::string& path);

/// Stages and outcomes have names of their own, and name bodies that there are.
void check_stages(const Scene& scene);
void check_outcomes(const Scene& scene);

}  // namespace palpate

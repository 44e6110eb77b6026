#pragma once

#include <string_view>

#include <palpate/material.hpp>

namespace palpate::fem {

/// Throws Error(owner, key, found, expected) for the first value of a material that is not finite or
/// outside the range that material.hpp gives.
void check_material(const Material& material, std::string_view owner);

}  // namespace palpate::fem

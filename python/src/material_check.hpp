#pragma once

#include <palpate/material.hpp>

namespace palpate::python {

/// Throws Error with the source "Material" and the name of the value if a scene would be refused for it.
void check_material(const Material& material);

}  // namespace palpate::python

#include "fem/material_check.hpp"

#include <cmath>
#include <string>

#include <palpate/error.hpp>

#include "number_text.hpp"

namespace palpate::fem {
void check_material(const Material& material, std::string_view owner) {
  const auto require = [&](bool good, double value, const char* key, const char* expected) {
    if (!good || !std::isfinite(value)) throw Error(std::string(owner), key, number_text(value), expected);
  };
  require(material.young_modulus > 0.0, material.young_modulus, "young_modulus", "a number > 0 (Pa)");
  require(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5, material.poisson_ratio,
          "poisson_ratio", "a number > -1 and < 0.5");
  require(material.density > 0.0, material.density, "density", "a number > 0 (kg/m^3)");
  require(material.mass_damping >= 0.0, material.mass_damping, "mass_damping", "a number >= 0 (1/s)");
  require(material.stiffness_damping >= 0.0, material.stiffness_damping, "stiffness_damping",
          "a number >= 0 (s)");
  const double yield = material.plastic_yield.value_or(0.0);
  require(yield >= 0.0, yield, "plastic_yield", "a number >= 0");
  require(material.plastic_creep >= 0.0, material.plastic_creep, "plastic_creep", "a number >= 0 (1/s)");
  const double maximum = material.plastic_maximum.value_or(0.0);
  require(maximum >= 0.0, maximum, "plastic_maximum", "a number >= 0");
}

}  // namespace palpate::fem

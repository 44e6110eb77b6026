#include "fem/material_check.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include <palpate/error.hpp>

#include "number_text.hpp"

namespace palpate::fem {
namespace {

void refuse(std::string_view owner, const char* key, const std::string& found, const std::string& expected) {
  throw Error(std::string(owner), key, found, expected);
}

/// The lowest Poisson ratio for which the bulk modulus of the law, lambda + 5/8 first, is positive.
double least_poisson_ratio(const Material& material) {
  const double fraction = material.model == MaterialModel::mooney_rivlin ? material.mooney_fraction : 0.0;
  const double factor = 5.0 / 6.0 * (1.0 - fraction);            // of mu
  return std::max(-1.0, 0.0 - factor / (2.0 * (1.0 - factor)));  // never -0
}

void check_fibres(const Fibres& fibres, std::string_view owner) {
  const Vec3& d = fibres.direction;
  const double size = d.x * d.x + d.y * d.y + d.z * d.z;
  if (!(size > 0.0) || !std::isfinite(size))
    refuse(owner, "fibres.direction", "a length of " + number_text(std::sqrt(size)), "a direction");
  const auto require = [&](double value, const char* key, const char* expected) {
    if (!(value >= 0.0) || !std::isfinite(value)) refuse(owner, key, number_text(value), expected);
  };
  require(fibres.stiffness, "fibres.stiffness", "a number >= 0 (Pa)");
  require(fibres.exponent, "fibres.exponent", "a number >= 0");
  require(fibres.active_stress, "fibres.active_stress", "a number >= 0 (Pa)");
  const auto& [times, factors] = fibres.activation;
  if (times.size() != factors.size()) {
    refuse(owner, "fibres.activation.factors", std::to_string(factors.size()),
           "as many as times, " + std::to_string(times.size()));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (!std::isfinite(times[i]) || (i > 0 && times[i] <= times[i - 1]))
      refuse(owner, "fibres.activation.times", number_text(times[i]), "times that grow");
    if (!(factors[i] >= 0.0 && factors[i] <= 1.0))
      refuse(owner, "fibres.activation.factors", number_text(factors[i]), "numbers in [0, 1]");
  }
}

void check_viscosity(const Viscosity& viscosity, std::string_view owner) {
  const auto& [fractions, times] = viscosity;
  if (times.size() != fractions.size()) {
    refuse(owner, "viscosity.times", std::to_string(times.size()) + " times",
           "as many as fractions, " + std::to_string(fractions.size()));
  }
  for (const double g : fractions) {
    if (!(g >= 0.0 && g < 1.0))
      refuse(owner, "viscosity.fractions", number_text(g), "numbers >= 0 whose sum is < 1");
  }
  const double sum = std::accumulate(fractions.begin(), fractions.end(), 0.0);
  if (!(sum < 1.0))
    refuse(owner, "viscosity.fractions", "a sum of " + number_text(sum), "a sum < 1: the rest never relaxes");
  for (const double time : times) {
    if (!(time > 0.0) || !std::isfinite(time))
      refuse(owner, "viscosity.times", number_text(time), "numbers > 0 (s)");
  }
}

void check_model(const Material& material, std::string_view owner) {
  const bool linear = material.model == MaterialModel::corotational;
  const auto index = static_cast<std::size_t>(material.model);
  if (index >= material_model_names.size())
    refuse(owner, "model", std::to_string(index), "one of the models");
  if (!(material.mooney_fraction >= 0.0 && material.mooney_fraction <= 1.0))
    refuse(owner, "mooney_fraction", number_text(material.mooney_fraction), "a number in [0, 1]");
  const auto kind = static_cast<std::size_t>(material.elements);
  if (kind >= element_kind_names.size())
    refuse(owner, "elements", std::to_string(kind), "linear or smoothed");
  if (material.elements == ElementKind::smoothed) {
    if (!(material.poisson_ratio >= 0.0)) {
      refuse(owner, "poisson_ratio", number_text(material.poisson_ratio),
             "a number >= 0 with smoothed elements");
    }
    if (material.plastic_yield)
      refuse(owner, "plastic_yield", "plasticity with smoothed elements", "linear elements");
  }
  if (!linear && material.plastic_yield) {
    refuse(owner, "plastic_yield", "plasticity with the model " + std::string(material_model_names[index]),
           "the model corotational");
  }
  if (linear && material.fibres.any())
    refuse(owner, "fibres", "fibres with the model corotational", "a hyperelastic model");
  const double least = linear ? -1.0 : least_poisson_ratio(material);
  if (!(material.poisson_ratio > least)) {
    refuse(owner, "poisson_ratio", number_text(material.poisson_ratio),
           "a number > " + number_text(least) + " with this model and mooney_fraction");
  }
  check_fibres(material.fibres, owner);
}

}  // namespace

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
  check_model(material, owner);
  check_viscosity(material.viscosity, owner);
}

}  // namespace palpate::fem

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include <palpate/material.hpp>

namespace palpate {

/// Kinds of tissue with published values. They are starting points: values differ by a factor of two and more
/// between people, ages, states and methods of measurement (docs/materials.md has the sources and the
/// spread).
enum class Tissue : std::uint8_t {
  liver,
  kidney,
  spleen,
  brain,
  fat,
  muscle,
  skin,
  sclera,
  tendon,
  cartilage,
  trabecular_bone,
  cortical_bone
};
/// Names of Tissue; index = enum value.
inline constexpr std::array<std::string_view, 12> tissue_names{
    "liver",  "kidney", "spleen",    "brain",           "fat",          "muscle", "skin",
    "sclera", "tendon", "cartilage", "trabecular-bone", "cortical-bone"};

/// Values of a tissue, with their source.
struct TissueInfo {
  double young_modulus = 0.0;   ///< Pa
  double poisson_ratio = 0.0;   ///< in (-1, 0.5)
  double density = 0.0;         ///< kg/m^3
  std::string_view measured{};  ///< method of measurement, with its spread
  std::string_view source{};    ///< author, journal, year
};
/// The published values of a tissue; the reference stays valid.
[[nodiscard]] const TissueInfo& tissue_info(Tissue tissue);

/// The material of a tissue in SI units: the values above, with the model corotational for tendon and bone
/// and stable_neo_hookean for others; all other values are defaults. Material::tissue names it.
[[nodiscard]] Material tissue_material(Tissue tissue);

}  // namespace palpate

#pragma once

namespace palpate {

/// Isotropic elastic material of a soft body, with Rayleigh damping C = mass_damping M + stiffness_damping K.
struct Material {
  double young_modulus = 1e5;      ///< Pa, > 0
  double poisson_ratio = 0.4;      ///< in (-1, 0.5)
  double density = 1000.0;         ///< kg/m^3, > 0
  double mass_damping = 0.0;       ///< 1/s, >= 0
  double stiffness_damping = 0.0;  ///< s, >= 0
};

}  // namespace palpate

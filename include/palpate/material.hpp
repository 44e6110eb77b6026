#pragma once

#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// Isotropic elastic material of a soft body, with Rayleigh damping C = mass_damping M + stiffness_damping K
/// and plasticity after Mueller & Gross 2004: while the elastic strain (Frobenius norm) is above
/// `plastic_yield`, the share plastic_creep * time_step of it (at most all) turns plastic in each step; the
/// norm of the plastic strain stays within `plastic_maximum`.
struct Material {
  double young_modulus = 1e5;               ///< Pa, > 0
  double poisson_ratio = 0.4;               ///< in (-1, 0.5)
  double density = 1000.0;                  ///< kg/m^3, > 0
  double mass_damping = 0.0;                ///< 1/s, >= 0
  double stiffness_damping = 0.0;           ///< s, >= 0
  std::optional<double> plastic_yield{};    ///< strain, >= 0; none: never yields
  double plastic_creep = 0.0;               ///< 1/s, >= 0
  std::optional<double> plastic_maximum{};  ///< strain, >= 0; none: no bound
};

/// What the tets of all bodies are made of.
struct Materials {
  /// One material per body. Not explicit, so that a list of materials can stand for Materials.
  Materials(std::vector<Material> of_bodies) : all(std::move(of_bodies)) {}
  Materials(std::initializer_list<Material> of_bodies) : all(of_bodies) {}
  /// Several materials in a body: one for each tet.
  Materials(std::vector<Material> materials, std::vector<Index> tets)
      : all(std::move(materials)), of_tet(std::move(tets)) {}

  /// The material of a tet (of all bodies' tets) that belongs to `body`.
  [[nodiscard]] const Material& of(Index tet, Index body) const {
    const Index material = of_tet.empty() ? body : of_tet[static_cast<std::size_t>(tet)];
    return all[static_cast<std::size_t>(material)];
  }

  std::vector<Material> all;  ///< the first n_bodies are those of the bodies; then any others
  std::vector<Index> of_tet;  ///< (n_tets) into `all`; empty: each tet has its body's
};

}  // namespace palpate

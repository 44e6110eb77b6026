#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/types.hpp>

namespace palpate {

/// A factor over time: linear between the times, constant before the first and after the last; 1 without any.
struct Ramp {
  std::vector<double> times{};    ///< s, ascending
  std::vector<double> factors{};  ///< one for each
};

/// The law of elasticity of a material (docs/materials.md has energies and sources). With small strains all
/// are Hooke's law of its Young's modulus and Poisson ratio.
enum class MaterialModel {
  corotational,        ///< linear in the strain of the corotated tet: fastest, for strains of some 10 %
  stable_neo_hookean,  ///< Smith, de Goes & Kim 2018: large strains; defined for every deformation
  mooney_rivlin,       ///< the same with a term in the second invariant
};
/// Names of MaterialModel; index = enum value.
inline constexpr std::array<std::string_view, 3> material_model_names{"corotational", "stable-neo-hookean",
                                                                      "mooney-rivlin"};

/// How strains are computed from the displacements of the corners of tets (docs/materials.md, "Smoothed
/// tets").
enum class ElementKind {
  linear,    ///< one strain in each tet: fastest; too stiff in bending and where poisson_ratio is above 0.45
  smoothed,  ///< means over several tets: accurate in both, at about four times the cost
};
/// Names of ElementKind; index = enum value.
inline constexpr std::array<std::string_view, 2> element_kind_names{"linear", "smoothed"};

/// One family of fibres in otherwise isotropic tissue (Holzapfel, Gasser & Ogden 2000), with an active
/// tension of muscle. Not with the corotational model.
///
/// With lambda the stretch along the fibres, their energy per volume at rest is stiffness / (2 exponent)
/// (exp(exponent E^2) - 1) for E = lambda^2 - 1 > 0, and none in compression; active fibres pull with
/// active_stress times their activation, as force per area at rest.
struct Fibres {
  Vec3 direction{1.0, 0.0, 0.0};  ///< at rest, of any length but zero
  double stiffness = 0.0;         ///< Pa, >= 0
  double exponent = 0.0;          ///< >= 0; 0: stiffness E^2 / 2
  double active_stress = 0.0;     ///< Pa, >= 0
  Ramp activation{};              ///< factors of active_stress, 0 to 1; none: always active
  /// In scenes: the array of the mesh file with a direction for each tet, which replaces `direction`. In C++
  /// use Model::fibre_of_tet; this member has no effect.
  std::string field{};
  /// Whether the fibres have any stiffness or active stress.
  [[nodiscard]] bool any() const { return stiffness != 0.0 || active_stress != 0.0; }
};

/// Stress relaxation: a Prony series (generalised Maxwell model, quasi-linear viscoelasticity) with any law
/// of elasticity. The relaxation modulus of a material with Young's modulus E, which is the long-term one, is
///   E (1 - sum_i g_i (1 - exp(-t / tau_i))) / (1 - sum_i g_i):
/// E / (1 - sum_i g_i) at first, E in the end. Poisson's ratio does not change. Activation of fibres is not
/// delayed.
struct Viscosity {
  std::vector<double> fractions{};  ///< g_i of the instantaneous modulus, >= 0, of sum < 1
  std::vector<double> times{};      ///< tau_i, s, > 0, one for each
  [[nodiscard]] bool any() const { return !fractions.empty(); }  ///< whether there is a term
};

/// A kind of tissue with published values; see tissues.hpp.
enum class Tissue : std::uint8_t;

/// Elastic material of a soft body, with Rayleigh damping C = mass_damping M + stiffness_damping K
/// and plasticity after Mueller & Gross 2004: while the elastic strain (Frobenius norm) is above
/// `plastic_yield`, the fraction plastic_creep * time_step of it (at most 1) becomes plastic in each step;
/// the norm of the plastic strain stays within `plastic_maximum`.
struct Material {
  double young_modulus = 1e5;               ///< Pa, > 0
  double poisson_ratio = 0.4;               ///< in (-1, 0.5)
  double density = 1000.0;                  ///< kg/m^3, > 0
  double mass_damping = 0.0;                ///< 1/s, >= 0
  double stiffness_damping = 0.0;           ///< s, >= 0
  std::optional<double> plastic_yield{};    ///< strain, >= 0; none: never yields. Needs model corotational
  double plastic_creep = 0.0;               ///< 1/s, >= 0
  std::optional<double> plastic_maximum{};  ///< strain, >= 0; none: no bound
  MaterialModel model = MaterialModel::corotational;  ///< law of elasticity
  /// For mooney_rivlin: the fraction of the shear modulus at rest due to the second invariant, in [0, 1]; C01
  /// / (C10 + C01).
  double mooney_fraction = 0.5;
  ElementKind elements = ElementKind::linear;  ///< smoothed: no plastic_yield
  Fibres fibres{};                             ///< with neither stiffness nor active stress: isotropic
  Viscosity viscosity{};                       ///< without terms: elastic
  /// The preset of the values, if any; it has no effect.
  std::optional<Tissue> tissue{};
};

/// The materials of the tets of all bodies.
struct Materials {
  /// One material per body. Not explicit, so that a list of materials converts to Materials.
  Materials(std::vector<Material> of_bodies) : all(std::move(of_bodies)) {}
  /// One material for each body, from a list in braces.
  Materials(std::initializer_list<Material> of_bodies) : all(of_bodies) {}
  /// Several materials in a body: one for each tet.
  Materials(std::vector<Material> materials, std::vector<Index> tets, std::vector<Vec3> fibres = {})
      : all(std::move(materials)), of_tet(std::move(tets)), fibre_of_tet(std::move(fibres)) {}

  /// The material of a tet; arguments as for index_of().
  [[nodiscard]] const Material& of(Index tet, Index body) const {
    return all[static_cast<std::size_t>(index_of(tet, body))];
  }
  /// The index in `all` of the material of a tet. O(1).
  /// \param tet   index among the tets of all bodies
  /// \param body  the body that the tet belongs to
  [[nodiscard]] Index index_of(Index tet, Index body) const {
    return of_tet.empty() ? body : of_tet[static_cast<std::size_t>(tet)];
  }

  std::vector<Material> all;  ///< the first n_bodies belong to the bodies, one each; then any others
  std::vector<Index> of_tet;  ///< (n_tets) into `all`; empty: each tet has the material of its body
  /// (n_tets) directions of fibres, of any length; empty, or zero for a tet: that of its material.
  std::vector<Vec3> fibre_of_tet{};
};

}  // namespace palpate

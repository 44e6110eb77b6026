#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/corner_sums.hpp"
#include "fem/hyperelastic.hpp"
#include "fem/matrix.hpp"
#include "fem/plasticity.hpp"
#include "fem/smoothing_domains.hpp"
#include "fem/tense_elements.hpp"
#include "fem/viscosity.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/element_pass.hpp"
#include "simd/hyperelastic_pass.hpp"
#include "simd/padded.hpp"
#include "simd/stress_pass.hpp"

namespace palpate::fem {

/// N arrays with one value per element each.
template <std::size_t N>
using Columns = std::array<simd::AlignedVector<double>, N>;

/// The deformation of an element, and the data for its stress; see Elements.
struct ElementDeformation {
  Matrix3 gradient;                   ///< F
  Matrix3 rotation;                   ///< R
  Matrix3 stretch;                    ///< R e: F - R without the plastic part
  SymmetricMatrix3 plastic_strain;    ///< p
  Vec3 twist;                         ///< w
  SymmetricMatrix3 viscous_stress{};  ///< of Maxwell elements, in the rotated frame (viscosity.hpp), Pa
  double viscous_energy = 0.0;        ///< of Maxwell elements, J/m^3
  double mu = 0.0;                    ///< Pa
  double lambda = 0.0;                ///< Pa, the current value
  bool hyperelastic = false;          ///< its stress follows from `law` and the gradient alone
  HyperelasticLaw law;
};

/// Tets of all bodies that deform, numbered body by body without obstacles, in the order in which the curve
/// of row_order.hpp first meets them, so that neighbours in space are close in memory.
///
/// There are two kinds of bodies. Those whose tets are all corotational and linear come first: their
/// stiffness is stored in the low-rank form below. A body with a hyperelastic or a smoothed tet has *tangent
/// blocks*: the stiffness of each tet that is not smoothed is stored as six blocks (hyperelastic.hpp), and
/// its tets are sorted by model. Only Elements uses this order. Bodies with a hyperelastic tet come last.
///
/// *Corotational tets* (Mueller & Gross, "Interactive Virtual Materials", Graphics Interface 2004).
/// With F = D_s D_m^-1 and R the rotation nearest to F, an element of volume V at rest has the energy
///   E = V (mu |F - R|^2 + lambda/2 tr^2(R^T F - I)).
/// Its force on corner i is f_i = -dE/dx_i = -V P g_i, with P = 2 mu (F - R) + lambda tr(R^T F - I) R and g_i
/// the gradient of corner i's shape function at rest: their warped force -R K (R^T x - x_rest). R makes
/// tr(R^T F) stationary, so that dR adds nothing. The stiffness blocks are as in the paper, K'_ij = R K_ij
/// R^T with
///   K_ij = V (lambda g_i g_j^T + mu g_j g_i^T + mu (g_i . g_j) I),
/// minus the derivative of the force at fixed R: symmetric and positive semi-definite.
///
/// If the material can yield, an element has a plastic strain p (plasticity.hpp), and its energy is that of
/// the elastic strain e = R^T F - I - p:
///   E = V (mu |e|^2 + lambda/2 tr^2(e)),  P = R (2 mu (e - [w]_x) + lambda tr(e) I),
/// the exact derivative at fixed p. w (plastic_twist) comes from dR, since R no longer makes the energy
/// stationary. K' is unchanged.
///
/// *Hyperelastic tets*: energy V Psi(F), forces -V P g_i, and stiffness blocks V g_i : dP/dF : g_j with the
/// positive semi-definite dP/dF of HyperelasticTangent.
///
/// *Smoothed tets*: SmoothingDomains have their stiffness and forces.
///
/// *Viscosity* (viscosity.hpp): forces are those of the energy
///   a E + V H : (R^T F - I),  P = a P_E + R (H + [w]_x),
/// with the stiffness a and the history H of the step and w of H (plastic_twist). set_factors() multiplies K'
/// by a; H does not change K'.
///
/// Deviations: R has det R = +1 for every F, so that inverted elements recover (docs/inversion.md); lambda
/// may be lowered per element (set_bulk_fraction), in E and P but not in K', which then is stiffer than the
/// derivative; F is built from displacements, so that it is exactly I at rest.
class Elements {
 public:
  /// \param materials  checked by the caller
  /// \param obstacles  per body, 1 if its tets are left out
  ///
  /// Throws Error naming body and tet if rounding leaves a tet no positive volume or no finite inverse.
  /// O(n_tets).
  Elements(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> obstacles);

  [[nodiscard]] Index size() const { return static_cast<Index>(tets_.size()); }
  [[nodiscard]] std::span<const Tet> corners() const {
    return std::span(corners_).first(tets_.size());
  }  ///< (n_elements x 4) points
  [[nodiscard]] std::span<const Index> tet_of_element() const {
    return tets_;
  }  ///< (n_elements) tets of Bodies
  [[nodiscard]] std::span<const Index> body_of_element() const { return body_; }  ///< (n_elements)
  [[nodiscard]] std::span<const double> volumes_rest() const {
    return std::span(volume_).first(tets_.size());
  }                                                                                 ///< (n_elements), m^3
  [[nodiscard]] std::span<const Vec3> points_rest() const { return points_rest_; }  ///< (n_points), m
  /// The first element with tangent blocks, or size().
  [[nodiscard]] Index tangent_begin() const { return tangent_begin_; }
  /// The first element of a body with a hyperelastic tet, or size().
  [[nodiscard]] Index nonlinear_begin() const { return nonlinear_begin_; }
  [[nodiscard]] const SmoothingDomains& smoothing() const { return smoothing_; }
  [[nodiscard]] bool is_smoothed(Index element) const {
    return is_smoothed(static_cast<std::size_t>(element));
  }
  /// Energy densities and stresses of smoothing().tets() at these displacements(); needs no update().
  [[nodiscard]] std::vector<HyperelasticResponse> smoothed_responses(
      const parallel::Threads& threads, std::span<const simd::Padded3> displacements) const;
  /// lambda / mu of each element (n_elements).
  [[nodiscard]] std::span<const double> ratios() const { return std::span(ratio_).first(tets_.size()); }

  /// Sets the factors >= 0 of the stiffness of each element (n_elements), 1 at first, from the next update()
  /// on.
  /// \param elastic_fractions  (n_elements) what part of each factor is of elastic forces; the rest is of
  ///     stiffness damping. Empty: as before, 1 at first
  void set_factors(std::span<const double> factors, std::span<const double> elastic_fractions = {});
  [[nodiscard]] double elastic_fraction(Index element) const { return at(elastic_fractions_, element); }
  /// Whether there are tets whose tangent jumps: passive fibres resist only where they are stretched. If
  /// damping had the jumps, too, a step could have no solution. So in a step it keeps the tangents of its
  /// start.
  [[nodiscard]] bool has_jumps() const { return has_jumps_; }
  /// From now on, damping of these tets acts by their tangents as of the last update(); call
  /// release_damping() before that.
  void hold_damping();
  void release_damping();
  /// Sets the fraction of lambda in an element's energy and forces, 0 to 1, 1 at first, from the next
  /// update() on.
  void set_bulk_fraction(Index element, double fraction) { at(bulk_fraction_, element) = fraction; }
  /// Computes rotations, forces, energies and rotated gradients of every element at these positions (n_points
  /// x 3, m), several elements at a time (simd/element_pass.hpp). O(n_elements).
  /// \param corner_forces  empty, or output (4 n_elements): the force on corner k of element e, N, at 4 e +
  ///                       k; the four sum to zero up to rounding
  void update(const parallel::Threads& threads, std::span<const Vec3> positions,
              std::span<simd::Padded3> corner_forces = {});
  /// update() without SIMD, element by element. Results agree with update() up to rounding.
  void update_one_by_one(std::span<const Vec3> positions, std::span<simd::Padded3> corner_forces = {});

  /// Elastic forces on points as of the last update(), N (n_points).
  [[nodiscard]] std::span<const simd::Padded3> point_forces() const { return point_forces_; }
  /// Adds K'_ij times its factor, N/m, of an element that is not smoothed to a block, as of the last
  /// update(). It is r X + X^T + tr(X) I, with a_i = sqrt(factor mu V) R g_i, r = lambda / mu and X = a_i
  /// a_j^T.
  void add_stiffness(Index element, int i, int j, Matrix3& block) const;
  /// The tangent blocks of an element, tangent_values numbers (hyperelastic.hpp).
  [[nodiscard]] const float* element_tangent(Index element) const;
  /// The tangent blocks of all elements, and behind them a block of zeros.
  [[nodiscard]] std::span<const float> tangents() const { return blocks_; }
  /// Place of block (i, j), i < j, of an element in tangents().
  [[nodiscard]] std::size_t tangent_place(Index element, int i, int j) const {
    return simd::block_stride * static_cast<std::size_t>(element - tangent_begin_) + block_place(i, j);
  }
  /// The stiffness block K'_ij at rest, with R = I.
  [[nodiscard]] Matrix3 stiffness_rest(Index element, int i, int j) const;
  [[nodiscard]] std::span<const double> factors() const { return factor_; }  ///< at least (n_elements)
  /// a_i of a corner.
  [[nodiscard]] Vec3 gradient(Index element, int corner) const;
  /// All a_i in float, corner by corner, with r as the fourth value; behind the last element at least one
  /// element of zeros.
  [[nodiscard]] std::span<const simd::Quad> gradients() const { return gradients_; }
  /// K' times the vectors (n_points), in double; the result is valid until the next call. K' is the sum of
  /// K'_e times its factor, or this part of it, as of the last update(). O(n_elements).
  std::span<const simd::Padded3> multiply(const parallel::Threads& threads,
                                          std::span<const simd::Padded3> vectors,
                                          StiffnessPart part = StiffnessPart::whole) const;
  /// K'_e of an element, times its factor, times the vectors at its corners; zero where it is smoothed.
  [[nodiscard]] std::array<Vec3, 4> multiply(Index element, const std::array<Vec3, 4>& vectors) const;
  /// Whether an element's damping is held; it is not smoothed.
  [[nodiscard]] bool is_held(Index element) const;
  /// The same for its damping, which is held.
  [[nodiscard]] std::array<Vec3, 4> multiply_held(Index element, const std::array<Vec3, 4>& vectors) const;
  /// Sets the activations of the fibres of each material, 0 to 1 (Materials::all), from the next update() on.
  /// Returns whether any has changed.
  bool set_activations(std::span<const double> activations);
  /// The bodies, of this many, that can have an ambient pressure (1): those without linear corotational tets.
  [[nodiscard]] std::vector<std::uint8_t> ambient_bodies(std::size_t body_count) const;
  /// Sets the pressure on all of the surface of each body (n_bodies), Pa, zero but for ambient_bodies();
  /// empty: none. From the next update() on, energies, forces and tangents of elements have it. Returns
  /// whether any has changed.
  bool set_ambient(std::span<const double> pressures);
  [[nodiscard]] bool has_ambient() const {
    return std::ranges::any_of(ambient_, [](double pressure) { return pressure != 0.0; });
  }
  [[nodiscard]] bool has_ambient(Index element) const {
    return element >= tangent_begin_ && ambient_[static_cast<std::size_t>(element - tangent_begin_)] != 0.0;
  }
  /// Energy of an element, whose derivative its forces are, as of the last update(), J. With that of an
  /// ambient pressure.
  [[nodiscard]] double energy(Index element) const { return at(energy_, element); }
  /// Elastic energy of an element at these positions, J, with that of its viscoelastic branches, without that
  /// of an ambient pressure. The element must not be smoothed. Needs no update().
  [[nodiscard]] double energy(Index element, std::span<const Vec3> positions) const;
  /// Energy that an ambient pressure has by the volume of an element at these positions, J: zero at rest. The
  /// element must not be smoothed. Needs no update().
  [[nodiscard]] double ambient_energy(Index element, std::span<const Vec3> positions) const;
  /// The deformation of an element at these positions; needs no update().
  [[nodiscard]] ElementDeformation deformation(Index element, std::span<const Vec3> positions) const;
  /// Displacements of points from rest (n_points), in the layout of the kernels.
  [[nodiscard]] std::vector<simd::Padded3> displacements(const parallel::Threads& threads,
                                                         std::span<const Vec3> positions) const;
  /// Strain and stress of the group of elements that begins at `first`, a multiple of simd::element_group.
  /// Elements whose stress is not purely elastic and corotational are left to deformation(). Needs no
  /// update().
  void find_group_stress(std::size_t first, std::span<const simd::Padded3> displacements,
                         simd::GroupStress& found) const;
  /// Whether the volume of an element was not positive, or NaN, at the last update().
  [[nodiscard]] bool inverted(Index element) const { return at(inverted_, element) != 0; }

  /// Plastic strain of each element in its rotated frame (n_elements), zero if it cannot yield; empty if no
  /// material can.
  [[nodiscard]] std::span<const SymmetricMatrix3> plastic_strains() const { return plastic_strains_; }
  /// Sets the plastic strains, an array of the same length. They stay zero where the material cannot yield.
  void set_plastic_strains(std::span<const SymmetricMatrix3> strains);
  /// Stores the plastic strains after a time step that ended at these positions in `next` (length of
  /// plastic_strains()), by plastic_flow() of each element. Inverted elements do not flow, so that a
  /// stress-free shape is never inverted. O(n_elements).
  void flow(const parallel::Threads& threads, std::span<const Vec3> positions, double time_step,
            std::span<SymmetricMatrix3> next) const;

  /// Corotational tets without tangent blocks that have geometric stiffness, as of the last update(). K'_e of
  /// those with tangent blocks includes it.
  [[nodiscard]] const TenseElements& tense() const { return tense_; }
  /// Sets the viscosity of the elements for steps of this length: the stiffness of all, and the stresses of
  /// those that are not smoothed. And which elements are tense(). Forces use it after set_time_step() or
  /// find_history(), and update().
  [[nodiscard]] const ViscousElements& viscosity() const { return viscosity_; }
  [[nodiscard]] bool is_viscous() const;
  void set_time_step(double time_step);
  void find_history(const parallel::Threads& threads);
  /// Ends a time step at these positions. O(viscous elements).
  void relax(const parallel::Threads& threads, std::span<const Vec3> positions);
  /// Stresses of the Maxwell elements, of tets and smoothing domains: part of the state. The order within a
  /// body does not depend on other bodies. Allocates.
  [[nodiscard]] std::vector<SymmetricMatrix3> viscous_stresses() const;
  [[nodiscard]] std::vector<Index> body_of_viscous_stress() const;
  /// Sets them from an array of that length.
  void set_viscous_stresses(std::span<const SymmetricMatrix3> stresses);
  /// Elastic energy of smoothed tets at the positions of the last update(), J, including that stored by
  /// viscosity. O(n_domains).
  [[nodiscard]] double smoothed_energy(const parallel::Threads& threads, std::vector<double>& partial) const {
    return smoothing_.energy(threads, displacements_, bulk_fraction_, partial);
  }

 private:
  /// The model of a group of tets. A kernel handles groups with one model.
  enum class GroupModel : std::uint8_t { corotational, hyperelastic, mixed };
  void add_bodies(const Bodies& bodies, const Materials& materials, std::span<const std::uint8_t> obstacles);
  void add_element(const Bodies& bodies, Index tet, Index body, const Materials& materials);
  void add_law(const Materials& materials, Index tet, Index body);
  void run_passes(const simd::ElementPass& pass, std::size_t begin, std::size_t end);
  [[nodiscard]] simd::HyperelasticPass hyperelastic_pass(const simd::ElementPass& pass);
  void update_element(std::size_t element, std::span<const Vec3> positions, double* forces);
  void update_hyperelastic(std::size_t element, std::span<const Vec3> positions, double* forces);
  void put_pulled(std::size_t element, std::span<const Vec3> positions);
  void put_corotational_blocks(std::size_t element);
  void add_tension(std::size_t element, const double* forces, std::vector<TenseElements::Tense>& tense);
  void add_tension_blocks(std::size_t element, const SymmetricMatrix3& q);
  void multiply_tense(const TenseElements::Tense& tense, const std::array<Vec3, 4>& vectors,
                      std::array<Vec3, 4>& products) const;
  void add_tense_products(std::size_t begin, std::size_t end, std::span<const simd::Padded3> vectors,
                          CornerSums::Values& products) const;
  [[nodiscard]] bool is_corotational(std::size_t element) const {
    return !is_hyperelastic(element) && !is_smoothed(element);
  }
  void multiply_full(std::size_t begin, std::size_t end, std::span<const simd::Padded3> vectors,
                     double* products) const;
  [[nodiscard]] HyperelasticLaw whole_law_of(std::size_t element) const;
  [[nodiscard]] HyperelasticLaw law_of(std::size_t element) const;
  [[nodiscard]] Matrix3 tangent_block(std::span<const float> blocks, Index element, int i, int j) const;
  /// Whether the tangent of an element jumps: it has passive fibres, and is not smoothed.
  [[nodiscard]] bool jumps(std::size_t element) const {
    if (!has_tangent_blocks(element)) return false;
    const std::size_t own = element - static_cast<std::size_t>(tangent_begin_);
    return pulls_[own] != 0 && laws_[simd::law_fibre_stiffness][own] > 0.0;
  }
  void finish_tangent(std::size_t element, std::span<const Vec3> positions);
  void put_part_of_held(std::size_t element, std::span<const simd::Padded3> vectors, StiffnessPart part,
                        double* products) const;
  [[nodiscard]] Matrix3 low_rank_block(Index element, int i, int j) const;
  [[nodiscard]] Matrix3 displacement_gradient(std::size_t element, std::span<const Vec3> positions) const;
  [[nodiscard]] bool has_tangent_blocks(std::size_t element) const {
    return element >= static_cast<std::size_t>(tangent_begin_);
  }
  [[nodiscard]] bool is_smoothed(std::size_t element) const {
    return has_tangent_blocks(element) && smoothed_[element - static_cast<std::size_t>(tangent_begin_)] != 0;
  }
  void update_smoothing(const parallel::Threads& threads);
  void add_smoothing(const Bodies& bodies, const Materials& materials);
  [[nodiscard]] bool is_hyperelastic(std::size_t element) const {
    return has_tangent_blocks(element) &&
           hyperelastic_[element - static_cast<std::size_t>(tangent_begin_)] != 0;
  }
  void collect_forces(std::size_t chunk, const CornerSums::Values& forces,
                      std::span<simd::Padded3> corner_forces);
  void set_gradient(std::size_t element, int corner, const Vec3& a);
  void add_plasticity(const Material& material);
  void add_viscosity(const Materials& materials);
  void add_viscous_forces(std::size_t element, std::span<const Vec3> positions, double* forces);
  void set_inviscid();
  void set_displacements(const parallel::Threads& threads, std::span<const Vec3> positions);
  void fill_group();
  [[nodiscard]] bool yields(std::size_t element) const {
    return !plasticity_.empty() && plasticity_[element].yield.has_value();
  }
  [[nodiscard]] bool has_yielded(std::size_t element) const {
    return yields(element) && plastic_strains_[element] != SymmetricMatrix3{};
  }
  [[nodiscard]] Matrix3 elastic_stretch(std::size_t element, const Matrix3& f, const Matrix3& rotation) const;
  [[nodiscard]] double energy_density(std::size_t element, const Matrix3& rotation,
                                      const Matrix3& stretch) const;
  [[nodiscard]] Vec3 gradient_rest(std::size_t element, int corner) const;
  [[nodiscard]] Matrix3 deformation_gradient(std::size_t element, std::span<const Vec3> positions) const;

  std::vector<Vec3> points_rest_;
  // By element, padded with zeros to whole groups (simd::element_group) and at least one more element. tets_
  // and the arrays below it are not padded.
  simd::AlignedVector<Tet> corners_;
  Columns<9> inverse_rest_;                ///< D_m^-1, row by row: row k is the gradient of corner k + 1
  simd::AlignedVector<double> stiffness_;  ///< mu V
  simd::AlignedVector<double> volume_;
  simd::AlignedVector<double> mu_;
  simd::AlignedVector<double> lambda_;
  simd::AlignedVector<double> ratio_;
  simd::AlignedVector<double> factor_;
  std::vector<double> elastic_fractions_;  ///< (n_elements) of the factors
  std::vector<double> bulk_fraction_;      ///< (n_elements) of lambda
  simd::AlignedVector<double> energy_;
  Columns<9> turned_;                           ///< a_i of corners 1 to 3, rotated
  simd::AlignedVector<simd::Quad> gradients_;   ///< a_i, corner by corner
  simd::AlignedVector<std::uint8_t> left_;      ///< 1: left by the pass, to be done one by one
  simd::AlignedVector<std::uint8_t> inverted_;  ///< as of the last update()
  std::vector<Index> tets_;
  std::vector<Index> body_;
  std::vector<GroupModel> group_models_;
  // Only of elements with tangent blocks, from tangent_begin_ on.
  Index tangent_begin_ = 0;
  Index nonlinear_begin_ = 0;
  SmoothingDomains smoothing_;
  std::vector<std::uint8_t> smoothed_;
  std::vector<std::uint8_t> hyperelastic_;
  Columns<simd::law_columns> laws_;    ///< laws with the full bulk modulus; padded to whole groups
  bool second_invariant_ = false;      ///< some element has a modulus of it
  bool fibres_ = false;                ///< some element has fibres
  std::vector<Index> material_;        ///< into Materials::all
  std::vector<double> active_stress_;  ///< Pa, at full activation
  std::vector<double> tension_;        ///< Pa; laws_ hold it divided by the stiffness factor of viscosity
  std::vector<double> ambient_;        ///< Pa; the same
  simd::AlignedVector<float> blocks_;  ///< simd::block_stride each
  std::vector<std::uint8_t> pulls_;    ///< 1: has fibres, and is not smoothed
  bool has_jumps_ = false;             ///< or a smoothed tet has
  std::vector<float> held_;            ///< as blocks_: those of damping that is held; otherwise empty
  simd::AlignedVector<simd::Padded3> displacements_;  ///< (n_points), scratch
  CornerSums force_sums_;
  simd::AlignedVector<simd::Padded3> point_forces_;
  mutable CornerSums product_sums_;
  mutable simd::AlignedVector<simd::Padded3> products_;  ///< (n_points)
  std::vector<Plasticity> plasticity_;                   ///< (n_elements), or empty where no material yields
  std::vector<SymmetricMatrix3> plastic_strains_;        ///< as plasticity_
  ViscousElements viscosity_;
  TenseElements tense_;
  parallel::ChunkedList<TenseElements::Tense> tense_lists_;
};

}  // namespace palpate::fem

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "fem/domain_tangents.hpp"
#include "fem/hyperelastic.hpp"
#include "fem/matrix.hpp"
#include "fem/viscosity.hpp"
#include "parallel/parallel.hpp"
#include "simd/aligned.hpp"
#include "simd/padded.hpp"

namespace palpate::fem {

struct ElementDeformation;

/// A tet whose strain is smoothed.
struct SmoothedTet {
  Index element = 0;   ///< of Elements
  Index material = 0;  ///< tets of different materials share no domain
  Tet corners{};
  std::array<Vec3, 4> gradients{};  ///< of the shape functions at rest, 1/m
  double volume = 0.0;              ///< at rest, m^3
  double mu = 0.0;                  ///< Pa
  double lambda = 0.0;              ///< Pa
  bool hyperelastic = false;        ///< its law is `law`, otherwise the corotational one
  HyperelasticLaw law;

  /// Corners of its edges.
  static constexpr std::array<std::array<std::size_t, 2>, 6> edges{
      {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};
  /// Index of the patch among the domains of a tet: after six edges and four points.
  static constexpr std::uint32_t patch_place = 10;
  /// The part of lambda of domains of points, up to 4 mu, Pa; that of patches is the rest. So patches exist
  /// where nu > 0.4.
  [[nodiscard]] double point_lambda() const {
    constexpr double rounding = 1.0 + 1e-9;  // nu = 0.4 has none
    return lambda <= 4.0 * mu * rounding ? lambda : 4.0 * mu;
  }
  [[nodiscard]] double patch_lambda() const { return lambda - point_lambda(); }
};

/// Selective smoothing of the strain of linear tets over edges and nodes (ES/NS-FEM-T4). It avoids locking of
/// nearly incompressible tissue and too much stiffness in bending. Liu & Nguyen-Thoi, "Smoothed
/// Finite Element Methods", CRC Press (2010), chapters 5 and 8; Onishi & Amaya, "A locking-free selective
/// smoothed finite element method using tetrahedral and triangular elements with adaptive mesh rezoning for
/// large deformation problems", Int. J. Numer. Meth. Eng. 99 (2014).
///
/// A domain has a sixth of the volume of each tet at an edge, or a quarter of each tet at a point, or each
/// tet of a patch (volume_patches.hpp), of one material. Its deformation gradient is the mean of theirs by
/// volume, F = I + sum_i u_i b_i^T over its points, with b_i the mean of the gradients at rest. Domains of
/// edges have the law without lambda (shape). Domains of points have lambda alone (volume), up to 4 mu, and
/// patches the rest of lambda:
///   corotational: mu |F - R|^2 and lambda/2 tr^2(R^T F - I); hyperelastic: the law with lambda = 0, fibres
///   included, and lambda/2 (J - 1)^2.
/// Forces are -V P b_i and stiffness blocks V b_i : dP/dF : b_j, as for a tet; of corotational ones without
/// the negative part (twists_of). Where active fibres pull, a part of the pressure of volume has its
/// term of dP/dF in the domains for shape (set_shape_tangent).
///
/// Deviations: with one domain per point, pressures of nearly incompressible tissue have a checkerboard
/// pattern, because there are too many of them for the velocities (the inf-sup condition). So there lambda
/// acts in patches, as in the F-bar patches of de Souza Neto, Pires & Owen, Int. J. Numer. Meth. Eng. 62
/// (2005), which are larger here. The part at points has a limited modulus, as the stabilisation of Puso &
/// Solberg, Int. J. Numer. Meth. Eng. 67 (2006). The parts for shape and volume are split by Lame's constants
/// and not by deviator and trace, so that each is stress-free at rest, also for nonlinear laws.
class SmoothingDomains {
 public:
  SmoothingDomains() = default;
  /// O(n_tets log).
  /// \param materials  indexed by SmoothedTet::material
  SmoothingDomains(std::vector<SmoothedTet> tets, std::size_t point_count,
                   std::span<const Material> materials);

  [[nodiscard]] bool empty() const { return tets_.empty(); }
  [[nodiscard]] std::size_t size() const { return volume_.size(); }
  [[nodiscard]] std::span<const SmoothedTet> tets() const { return tets_; }
  /// Points of a domain, ascending.
  [[nodiscard]] std::span<const Index> points(std::size_t domain) const {
    return std::span(points_).subspan(begin_[domain], begin_[domain + 1] - begin_[domain]);
  }
  /// The first element of a domain. All its elements have one material, and so the same damping.
  [[nodiscard]] Index element(std::size_t domain) const { return first_tet(domain).element; }

  /// Index of a point in a domain.
  struct Entry {
    std::uint32_t domain = 0;
    std::uint32_t place = 0;
  };
  /// The entries of a point (its indices in domains), domains ascending; empty where no tet is smoothed.
  [[nodiscard]] std::span<const Entry> entries(Index point) const;
  /// Index of a point's first entry among all entries.
  [[nodiscard]] std::size_t first_entry(Index point) const {
    return entry_begin_[static_cast<std::size_t>(point)];
  }

  /// Computes stresses, energies and tangents at these displacements (n_points). O(n_domains).
  /// \param factors         of the stiffness, per element (Elements)
  /// \param bulk_fractions  of lambda in energy and forces, per element
  void update(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
              std::span<const double> factors, std::span<const double> bulk_fractions);
  /// Adds the elastic forces of the last update() (n_points), N.
  void add_forces(const parallel::Threads& threads, std::span<simd::Padded3> forces) const;
  /// Adds the energies of the last update() to those of elements, J.
  void add_energies(const parallel::Threads& threads, std::span<double> energies) const;
  /// Sets which fraction of its factor is of elastic forces, for each element (Elements::set_factors()).
  void set_elastic_fractions(std::span<const double> fractions);
  /// As in Elements.
  void hold_damping() { held_tangents_ = tangents_; }
  void release_damping() { held_tangents_.clear(); }
  [[nodiscard]] bool is_held(std::size_t domain) const {
    return !held_tangents_.empty() && laws_[domain].fibre_stiffness > 0.0;
  }
  /// Adds K', or a part of it, times the vectors (n_points).
  void multiply(const parallel::Threads& threads, std::span<const simd::Padded3> vectors, StiffnessPart part,
                std::span<simd::Padded3> products) const;
  /// Calls add(place, product) for the points of a domain. The product is K' of the domain, or a part of it,
  /// times the vectors of its points, which value(place) gives.
  template <class Value, class Add>
  void multiply(std::size_t domain, StiffnessPart part, Value&& value, Add&& add) const {
    Matrix3 gradient;
    for (std::size_t k = 0; k < points(domain).size(); ++k)
      add_outer(gradient, 1.0, value(k), rest_gradients_[begin_[domain] + k]);
    const Matrix3 stress = stress_change(domain, gradient, part);
    for (std::size_t k = 0; k < points(domain).size(); ++k)
      add(k, stress * rest_gradients_[begin_[domain] + k]);
  }

  /// Sets tensions of active fibres, per element from `first` on, Pa, from the next update() on.
  void set_tensions(std::span<const double> tensions, Index first);
  /// Sets ambient pressures likewise (Elements::set_ambient()). They act on the volumes det(F) V of the
  /// domains, on each as much as it has of the bulk modulus: so its pressure is in balance there, and the
  /// domain has no negative eigenvalues. For uniform strain this is a pressure on the surface; otherwise the
  /// volume of a domain differs from that of its tets.
  void set_ambient(std::span<const double> pressures, Index first);

  /// Sets the viscosity of the domains, as of elements. A domain's stress is the Biot stress of its part of
  /// the law.
  [[nodiscard]] const ViscousElements& viscosity() const { return viscosity_; }
  [[nodiscard]] bool is_viscous() const { return !viscosity_.elements().empty(); }
  void set_time_step(double time_step) { viscosity_.set_time_step(time_step); }
  void find_history(const parallel::Threads& threads) { viscosity_.find_history(threads); }
  /// Ends a time step at these displacements. O(viscous domains).
  void relax(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
             std::span<const double> bulk_fractions);
  void set_viscous_stresses(std::span<const SymmetricMatrix3> stresses) { viscosity_.set_stresses(stresses); }
  /// Elastic energy at these displacements, J, including that stored by viscosity. O(n_domains).
  /// \param partial scratch of parallel::sum
  [[nodiscard]] double energy(const parallel::Threads& threads, std::span<const simd::Padded3> displacements,
                              std::span<const double> bulk_fractions, std::vector<double>& partial) const;

  /// Prepares for_each_block() after update(). O(n_domains).
  void prepare_blocks(const parallel::Threads& threads) const;
  using Block = std::array<float, 9>;
  /// For an entry (a point in a domain), calls add(block) for each other point of the domain, ascending. The
  /// block is the stiffness between the two points times its factor, as of the last update(). Blocks (i, j)
  /// and (j, i) have transposed bits.
  template <class Add>
  void for_each_block(const Entry& entry, Add&& add) const {
    const std::size_t first = begin_[entry.domain];
    const std::size_t own = first + entry.place;
    const auto for_others = [&](auto&& block_with) {
      for (std::size_t k = first; k < begin_[entry.domain + 1]; ++k) {
        if (k != own) add(block_with(k));
      }
    };
    if (first_tet(entry.domain).hyperelastic) {
      const ContractedTangent contracted = contract(entry.domain, own);
      for_others([&](std::size_t k) {
        return k > own ? contracted_block(contracted, k)
                       : transposed_block(contracted_block(contract(entry.domain, k), own));
      });
    } else {
      const bool volume = is_volume(entry.domain);
      for_others([&](std::size_t k) { return corotational_block(rotated_[own], rotated_[k], volume); });
    }
  }
  /// Stiffness block at rest, in the rotated frame.
  [[nodiscard]] Matrix3 block_rest(std::size_t domain, const Matrix3& rotation, std::size_t i,
                                   std::size_t j) const;
  /// The rotation of a domain at these positions.
  [[nodiscard]] Matrix3 rotation(std::size_t domain, std::span<const Vec3> rest,
                                 std::span<const Vec3> positions) const;

  /// Energy density and first Piola-Kirchhoff stress of each of tets() at these displacements: means over
  /// their domains, so that forces are -V P g_i. Allocates. O(n_domains).
  [[nodiscard]] std::vector<HyperelasticResponse> responses(const parallel::Threads& threads,
                                                            std::span<const simd::Padded3> displacements,
                                                            std::span<const double> bulk_fractions) const;

 private:
  static constexpr std::size_t edges_of_tet = SmoothedTet::edges.size();
  /// Its edges, then its points, then its patch.
  static constexpr std::size_t domains_of_tet = SmoothedTet::patch_place + 1;
  /// Fraction of the volume of a tet in its domain number `place`.
  static constexpr double volume_fraction(std::size_t place) {
    if (place == SmoothedTet::patch_place) return 1.0;
    return place < edges_of_tet ? 1.0 / 6.0 : 1.0 / 4.0;
  }
  struct Member {
    std::uint32_t tet = 0;
    std::uint32_t place = 0;  ///< index of the domain among the domains of the tet
  };
  void add_domain(std::span<const Member> members);
  void list_entries(std::size_t point_count);
  void set_law(std::span<const Member> members);
  /// Four lanes, the last one unused.
  struct alignas(16) Lanes {
    std::array<float, 4> values{};
    void add_scaled(float factor, const Lanes& a) {
      for (std::size_t k = 0; k < 4; ++k) values[k] += factor * a.values[k];
    }
  };
  /// The tangent dP/dF of a domain: for i, c and d, the terms dP_ic / dF_jd over j.
  using TangentRows = std::array<Lanes, 27>;
  /// The tangent times the gradient of a point: for i and d, a vector over j.
  using ContractedTangent = std::array<Lanes, 9>;
  [[nodiscard]] std::array<float, 3> rest_gradient(std::size_t k) const {
    const Vec3& b = rest_gradients_[k];
    return {static_cast<float>(b.x), static_cast<float>(b.y), static_cast<float>(b.z)};
  }
  [[nodiscard]] ContractedTangent contract(std::size_t domain, std::size_t point) const {
    const TangentRows& tangent = tangent_rows_[domain];
    const std::array<float, 3> b = rest_gradient(point);
    ContractedTangent sum;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t d = 0; d < 3; ++d) {
        for (std::size_t c = 0; c < 3; ++c) sum[3 * i + d].add_scaled(b[c], tangent[9 * i + 3 * c + d]);
      }
    }
    return sum;
  }
  [[nodiscard]] Block contracted_block(const ContractedTangent& tangent, std::size_t point) const {
    const std::array<float, 3> b = rest_gradient(point);
    Block block;
    for (std::size_t i = 0; i < 3; ++i) {
      Lanes row;
      for (std::size_t d = 0; d < 3; ++d) row.add_scaled(b[d], tangent[3 * i + d]);
      for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] = row.values[j];
    }
    return block;
  }
  static Block transposed_block(const Block& b) {
    return {b[0], b[3], b[6], b[1], b[4], b[7], b[2], b[5], b[8]};
  }
  /// A point's index in a corotational domain, so that blocks are sums of products of two of them.
  struct RotatedGradient {
    simd::Quad strain;                ///< sqrt(factor V modulus) R b_i
    std::array<simd::Quad, 3> twist;  ///< sqrt(factor V) a_k x R b_i, a_k of Twists
  };
  static void add_outer_product(const simd::Quad& a, const simd::Quad& b, Block& block) {
    const Block product{a.x * b.x, a.x * b.y, a.x * b.z, a.y * b.x, a.y * b.y,
                        a.y * b.z, a.z * b.x, a.z * b.y, a.z * b.z};
    for (std::size_t k = 0; k < 9; ++k) block[k] += product[k];
  }
  static Block corotational_block(const RotatedGradient& a, const RotatedGradient& b, bool volume) {
    Block block{};
    if (volume) {
      add_outer_product(a.strain, b.strain, block);
    } else {
      const float trace = a.strain.x * b.strain.x + a.strain.y * b.strain.y + a.strain.z * b.strain.z;
      for (std::size_t k = 0; k < 9; k += 4) block[k] = trace;
      add_outer_product(b.strain, a.strain, block);
    }
    for (std::size_t k = 0; k < 3; ++k) add_outer_product(a.twist[k], b.twist[k], block);
    return block;
  }
  /// The first tet of a domain. All its tets have one material.
  [[nodiscard]] const SmoothedTet& first_tet(std::size_t domain) const {
    return tets_[domain_tets_[tet_begin_[domain]]];
  }
  [[nodiscard]] bool is_volume(std::size_t domain) const { return domain >= volume_begin_; }
  [[nodiscard]] double modulus(std::size_t domain) const;
  [[nodiscard]] double bulk_fraction(std::size_t domain, std::span<const double> fractions) const;
  [[nodiscard]] Matrix3 displacement_gradient(std::size_t domain,
                                              std::span<const simd::Padded3> displacements) const;
  /// Deformation of a domain, like that of an element with its part of the law.
  /// \param h  F - I
  /// \param tension  factor of the tension of active fibres
  [[nodiscard]] ElementDeformation deformation(std::size_t domain, const Matrix3& h, double fraction,
                                               double tension) const;
  [[nodiscard]] HyperelasticResponse step_response(std::size_t domain, const Matrix3& h,
                                                   const ElementDeformation& deformation) const;
  /// The response, given the current stresses of the Maxwell elements.
  [[nodiscard]] HyperelasticResponse response_now(std::size_t domain, const Matrix3& h,
                                                  double fraction) const;
  [[nodiscard]] HyperelasticLaw law(std::size_t domain, double fraction, double tension) const;
  /// Principal axes at the positions, each with the root of the stiffness of the twist about it, Pa.
  using Twists = std::array<Vec3, 3>;
  [[nodiscard]] static Twists twists_of(const ElementDeformation& deformation, double ambient);
  void set_tangent(std::size_t domain, const Matrix3& h, const ElementDeformation& deformation);
  void set_volume_tangent(std::size_t domain, const Matrix3& h, HyperelasticLaw law);
  void set_shape_tangent(std::size_t domain, const Matrix3& h, HyperelasticLaw law);
  [[nodiscard]] double mean_added(std::size_t domain, std::size_t first) const;
  [[nodiscard]] double mean_added_of_ends(std::size_t domain) const;
  [[nodiscard]] Matrix3 stress_change(std::size_t domain, const Matrix3& gradient) const;
  [[nodiscard]] Matrix3 stress_change(std::size_t domain, const Matrix3& gradient, StiffnessPart part) const;

  std::vector<SmoothedTet> tets_;
  std::vector<std::uint32_t> domain_of_tet_;  ///< domains_of_tet each
  std::size_t volume_begin_ = 0;         ///< index of the first domain of a point; those of edges come first
  std::size_t patch_begin_ = 0;          ///< index of the first patch
  std::vector<std::uint32_t> begin_{0};  ///< (n_domains + 1)
  std::vector<Index> points_;
  std::vector<Vec3> rest_gradients_;  ///< b_i, in the order of points_
  std::vector<double> volume_;
  std::vector<std::uint32_t> tet_begin_{0};  ///< (n_domains + 1)
  std::vector<std::uint32_t> domain_tets_;   ///< of each domain, into tets_
  std::vector<HyperelasticLaw> laws_;      ///< of hyperelastic tissue, otherwise undefined; with full lambda
  std::vector<double> elastic_fractions_;  ///< (n_domains) of the factor
  std::vector<double> ambient_;            ///< (n_domains) Pa, divided by the stiffness factor of viscosity
  std::vector<std::size_t> entry_begin_;   ///< (n_points + 1)
  std::vector<Entry> entries_;
  ViscousElements viscosity_;           ///< Maxwell elements of the domains
  std::vector<Index> smoothed_points_;  ///< points with an entry
  // Results of the last update().
  std::vector<Matrix3> stresses_;   ///< V P, N m
  std::vector<double> densities_;   ///< energy densities, J/m^3
  std::vector<double> scales_;      ///< factor V
  std::vector<Matrix3> rotations_;  ///< of corotational tissue
  std::vector<SymmetricMatrix3>
      twist_stiffness_;  ///< factor V sum a_k a_k^T of Twists, of corotational tissue
  simd::AlignedVector<RotatedGradient> rotated_;  ///< as points_, of corotational tissue

  DomainTangents tangents_;       ///< of hyperelastic tissue
  DomainTangents held_tangents_;  ///< of damping that is held; otherwise empty

  mutable std::vector<Matrix3> changes_;           ///< scratch
  mutable std::vector<TangentRows> tangent_rows_;  ///< scratch of prepare_blocks(), of hyperelastic tissue
};

}  // namespace palpate::fem

#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// The thickness of the tissue around each tet, m: the least height of the tet times the number of layers of
/// tets there. A layer is counted by edges between the surface and the innermost point that is reached from
/// it by going inwards. O(n_points + n_tets).
std::vector<double> tissue_thickness(const Bodies& bodies);

/// Corotational elements under a tension that matters in a step.
///
/// The stiffness K' of corotational elements is the derivative of their forces at fixed rotations. The rest
/// of the derivative is the geometric stiffness: an element under tension resists its rotation. Without it, a
/// step takes the force across a stretched strap from its start. A vibration of wave number k, which K' damps
/// only by bending, then gains energy if
///   h^2 s k^2 / rho > 4 + h^2 E d^2 k^4 / (12 rho),
/// with the tension s and the thickness d (von Neumann's condition; bending of a plate). There is such a k if
/// s h > 1.155 d sqrt(E rho). The thickness is measured by least heights of tets, which are 0.6 to 1 of a
/// layer. So from s h = d sqrt(E rho) on, with the largest sum s of two principal stresses, elements get
/// a part of their geometric stiffness, and all of it from twice as much on; what is left out stays below the
/// bound:
///   G_ij = V/2 [R g_i]_x^T M [R g_j]_x,  M = (tr(S) I - S) / 2 without negative eigenvalues,
/// with the stress S = P R^T. The exact M has the pairs (S_a + S_b) / (s_a + s_b) of principal stresses and
/// stretches (the derivative of R, as by Barbic, "Exact corotational linear FEM stiffness matrix", 2012);
/// here the stretches are 1. All other elements have K' alone: it never acts against a rotation, and costs
/// less. So have elements that are torn to about three times their length or more, by their energy: with it,
/// bodies came back from inverted states more slowly.
class TenseElements {
 public:
  /// An element with geometric stiffness. Its blocks, with the factor of the element, are [a_i]_x^T Q [a_j]_x
  /// with a_i of Elements.
  struct Tense {
    Index element;
    SymmetricMatrix3 q;
  };

  /// Appends an element.
  void add(double thickness, const Material& material, double volume);
  /// None is tense before the first call.
  void set_time_step(double time_step);
  /// Whether an element with this energy may be tense.
  [[nodiscard]] bool may_be_tense(std::size_t element, double energy) const {
    return energy > least_energy_[element];
  }
  /// Appends an element with this stress if it is tense.
  /// \param energy  per volume, Pa
  void add_if_tense(std::size_t element, const SymmetricMatrix3& stress, double energy,
                    std::vector<Tense>& tense) const;
  /// The tense elements, from lists of chunks.
  void take(const parallel::Threads& threads, parallel::ChunkedList<Tense>& lists);

  /// All, ascending.
  [[nodiscard]] std::span<const Tense> all() const { return tense_; }
  /// Those among elements [begin, end).
  [[nodiscard]] std::span<const Tense> among(std::size_t begin, std::size_t end) const;
  /// Null if the element is not tense.
  [[nodiscard]] const Tense* find(Index element) const;

 private:
  std::vector<double> scale_;         ///< (n_elements) d sqrt(E rho)
  std::vector<double> stiffness_;     ///< (n_elements) 2 mu + 3 lambda times 8 / volume
  std::vector<double> mu_;            ///< (n_elements)
  std::vector<double> least_energy_;  ///< (n_elements) energy below which no element is tense
  double time_step_ = 0.0;
  std::vector<Tense> tense_;
};

/// [a]_x^T Q [b]_x
[[nodiscard]] Matrix3 geometric_block(const SymmetricMatrix3& q, const Vec3& a, const Vec3& b);

}  // namespace palpate::fem

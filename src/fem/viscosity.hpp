#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/material.hpp>

#include "fem/matrix.hpp"
#include "parallel/parallel.hpp"

namespace palpate::fem {

/// Instantaneous Young's modulus, before any relaxation: E / (1 - sum_i g_i), Pa.
[[nodiscard]] double instantaneous_modulus(const Material& material);

/// Stresses of the Maxwell elements of tets whose material has a Viscosity, over time.
///
/// With the elastic stress T(t) of a tet in its rotated frame (Biot's, the symmetric part of R^T P), its
/// stress is T + sum_i q_i, where q_i is the convolution of dT/dt with gamma_i exp(-t / tau_i), gamma_i = g_i
/// / (1 - sum_j g_j). T is assumed linear in a step of length h; then the convolution is exact (Taylor,
/// Pister & Goudreau, Int. J. Numer. Meth. Eng. 2 (1970); Simo & Hughes, "Computational Inelasticity", 1998,
/// section 10.3, use the midpoint rule instead):
///   q_i' = e_i q_i + gamma_i m_i (T' - T),  e_i = exp(-h / tau_i),  m_i = (1 - e_i) tau_i / h.
/// So the stress at the end of a step is stiffness() T' + history(), with the history known at its start.
/// Unconditionally dissipative in implicit Euler if T is linear in the strain: the work of q_i' in a step is
/// at least the increase of |q_i|^2 / (2 gamma_i), since e_i^2 <= m_i (2 - m_i).
class ViscousElements {
 public:
  ViscousElements() = default;
  /// \param material_of_element  into `materials`
  /// \param without_stress       per element, 1 if its stresses are stored elsewhere (smoothed tets); or
  ///                             empty
  ViscousElements(std::span<const Material> materials, std::span<const Index> material_of_element,
                  std::span<const std::uint8_t> without_stress = {});

  /// Whether the stresses of an element are stored here.
  [[nodiscard]] bool has(std::size_t element) const { return !place_.empty() && place_[element] >= 0; }
  /// The elements whose stresses are stored here, ascending.
  [[nodiscard]] std::span<const Index> elements() const { return elements_; }

  void set_time_step(double time_step);
  /// Factor of the elastic stress at the end of a step, as of set_time_step(); 1 without viscosity.
  [[nodiscard]] double stiffness(std::size_t element) const {
    return material_.empty() ? 1.0 : series_[static_cast<std::size_t>(material_[element])].stiffness;
  }
  /// Computes the history from the current stresses, for steps of this length. O(elements x terms).
  void find_history(const parallel::Threads& threads);
  [[nodiscard]] const SymmetricMatrix3& history(std::size_t element) const {
    return history_[place(element)];
  }
  /// sum_i q_i, the current value.
  [[nodiscard]] SymmetricMatrix3 stress(std::size_t element) const;
  /// sum_i q_i : C^-1 : q_i / (2 gamma_i) with Hooke's law C, J/m^3: the energy of Maxwell elements for a
  /// linear law. With mu = 0 only the spherical part of q_i counts.
  [[nodiscard]] double energy_density(std::size_t element, double mu, double lambda) const;
  /// Ends a step of one element.
  /// \param elastic  T at its end
  void advance(std::size_t element, const SymmetricMatrix3& elastic);

  /// T and q_i of each element, in order: the state.
  [[nodiscard]] std::span<const SymmetricMatrix3> stresses() const { return stresses_; }
  /// Number of stresses of elements()[k].
  [[nodiscard]] std::size_t stress_count(std::size_t k) const {
    return 1 + series_[series_of_[k]].terms.size();
  }
  /// Sets them from an array of that length.
  void set_stresses(std::span<const SymmetricMatrix3> stresses);

 private:
  struct Term {
    double modulus = 0.0;    ///< gamma_i
    double time = 1.0;       ///< tau_i
    double decay = 1.0;      ///< e_i
    double stiffness = 0.0;  ///< gamma_i m_i
  };
  struct Series {
    std::vector<Term> terms;
    double stiffness = 1.0;
  };
  [[nodiscard]] std::size_t place(std::size_t element) const {
    return static_cast<std::size_t>(place_[element]);
  }
  [[nodiscard]] std::size_t series_of(std::size_t element) const { return series_of_[place(element)]; }
  [[nodiscard]] const SymmetricMatrix3* stresses_of(std::size_t place) const {
    return stresses_.data() + first_[place];
  }

  std::vector<Series> series_;          ///< (n_materials), empty for materials without viscosity
  std::vector<Index> material_;         ///< (n_elements), or empty if no material has a series
  std::vector<Index> elements_;         ///< elements with stresses
  std::vector<Index> place_;            ///< (n_elements) index into elements_, -1 for others; or empty
  std::vector<std::size_t> series_of_;  ///< for each of elements_, like the next array
  std::vector<std::size_t> first_;      ///< into stresses_
  std::vector<SymmetricMatrix3> history_;
  std::vector<SymmetricMatrix3> stresses_;
};

}  // namespace palpate::fem

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "fem/hyperelastic.hpp"
#include "fem/pulled_tangent.hpp"

namespace palpate::fem {

/// The tangents dP/dF of hyperelastic smoothing domains: the one of the law or, where fibres pull, the whole
/// one; and c dF.
struct DomainTangents {
  std::vector<HyperelasticTangent> of_law;
  std::vector<double> added;         ///< c, Pa
  std::vector<WholeTangent> whole;   ///< (n_domains) with fibres, otherwise empty
  std::vector<std::uint8_t> pulled;  ///< (n_domains) 1: `whole` is the tangent

  [[nodiscard]] bool empty() const { return of_law.empty(); }
  void resize(std::size_t domains, bool fibres);
  /// No tangents; keeps the memory.
  void clear();
  /// Sets the tangent of a domain at h = F - I, and its c.
  void set(std::size_t domain, const HyperelasticLaw& law, const Matrix3& h, double addend);
  /// As the functions stress_change_of().
  [[nodiscard]] Matrix3 stress_change(std::size_t domain, const Vec3& fibre,
                                      const Matrix3& gradient_change) const;
};

}  // namespace palpate::fem

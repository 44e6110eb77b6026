#include "fem/domain_tangents.hpp"

namespace palpate::fem {

void DomainTangents::resize(std::size_t domains, bool fibres) {
  of_law.resize(domains);
  added.resize(domains, 0.0);
  whole.resize(fibres ? domains : 0);
  pulled.resize(domains, 0);
}

void DomainTangents::clear() {
  of_law.clear();
  added.clear();
  whole.clear();
  pulled.clear();
}

void DomainTangents::set(std::size_t domain, const HyperelasticLaw& law, const Matrix3& h, double addend) {
  added[domain] = addend;
  pulled[domain] = !whole.empty() && pulled_tangent(law, h, whole[domain]) ? 1 : 0;
  if (pulled[domain] == 0) of_law[domain] = tangent(law, h, 0.0);
}

Matrix3 DomainTangents::stress_change(std::size_t domain, const Vec3& fibre,
                                      const Matrix3& gradient_change) const {
  Matrix3 change = pulled[domain] != 0 ? stress_change_of(whole[domain], gradient_change)
                                       : stress_change_of(of_law[domain], fibre, gradient_change);
  for (std::size_t k = 0; k < 9; ++k) change.values[k] += added[domain] * gradient_change.values[k];
  return change;
}

}  // namespace palpate::fem

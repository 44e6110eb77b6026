#include "fem/viscosity.hpp"

#include <algorithm>
#include <numeric>

#include "fem/plasticity.hpp"
#include "geometry/exponential.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

constexpr std::size_t relaxed_element_grain = 256;

/// (1 - exp(-x)) / x for x >= 0.
double mean_decay(double x, double decay) {
  return x < 1e-3 ? 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)) : (1.0 - decay) / x;
}

/// 1 - sum_i g_i
double rest_of(const std::vector<double>& fractions) {
  return 1.0 - std::accumulate(fractions.begin(), fractions.end(), 0.0);
}

}  // namespace

double instantaneous_modulus(const Material& material) {
  return material.young_modulus / rest_of(material.viscosity.fractions);
}

ViscousElements::ViscousElements(std::span<const Material> materials,
                                 std::span<const Index> material_of_element,
                                 std::span<const std::uint8_t> without_stress) {
  for (const Material& material : materials) {
    const auto& [fractions, times] = material.viscosity;
    const double rest = rest_of(fractions);
    Series& series = series_.emplace_back();
    for (std::size_t i = 0; i < fractions.size(); ++i) {
      if (fractions[i] > 0.0) series.terms.push_back({.modulus = fractions[i] / rest, .time = times[i]});
    }
  }
  for (std::size_t e = 0; e < material_of_element.size(); ++e) {
    const auto material = static_cast<std::size_t>(material_of_element[e]);
    if (series_[material].terms.empty()) continue;
    if (material_.empty()) material_.assign(material_of_element.begin(), material_of_element.end());
    if (!without_stress.empty() && without_stress[e] != 0) continue;
    place_.resize(material_of_element.size(), -1);
    place_[e] = static_cast<Index>(elements_.size());
    elements_.push_back(static_cast<Index>(e));
    series_of_.push_back(material);
    first_.push_back(stresses_.size());
    stresses_.resize(stresses_.size() + 1 + series_[material].terms.size());
  }
  history_.resize(elements_.size());
}

void ViscousElements::set_time_step(double time_step) {
  for (Series& series : series_) {
    series.stiffness = 1.0;
    for (Term& term : series.terms) {
      const double x = time_step / term.time;
      term.decay = exponential(-x);
      term.stiffness = term.modulus * mean_decay(x, term.decay);
      series.stiffness += term.stiffness;
    }
  }
}

void ViscousElements::find_history(const parallel::Threads& threads) {
  parallel::for_each(threads, elements_.size(), relaxed_element_grain, [&](std::size_t k) {
    const SymmetricMatrix3* const q = stresses_of(k);
    const std::vector<Term>& terms = series_[series_of_[k]].terms;
    SymmetricMatrix3 sum;
    for (std::size_t i = 0; i < terms.size(); ++i)
      sum = sum + terms[i].decay * q[i + 1] + (-terms[i].stiffness) * q[0];
    history_[k] = sum;
  });
}

SymmetricMatrix3 ViscousElements::stress(std::size_t element) const {
  const SymmetricMatrix3* const q = stresses_of(place(element));
  SymmetricMatrix3 sum;
  for (std::size_t i = 1; i <= series_[series_of(element)].terms.size(); ++i) sum = sum + q[i];
  return sum;
}

double ViscousElements::energy_density(std::size_t element, double mu, double lambda) const {
  const SymmetricMatrix3* q = stresses_of(place(element));
  const double spherical = lambda / (3.0 * lambda + 2.0 * mu);
  double sum = 0.0;
  for (const Term& term : series_[series_of(element)].terms) {
    ++q;
    const double trace = q->xx + q->yy + q->zz;
    if (mu == 0.0) {
      sum += trace * trace / (18.0 * lambda * term.modulus);
      continue;
    }
    const double size = norm(*q);
    sum += (size * size - spherical * trace * trace) / (4.0 * mu * term.modulus);
  }
  return sum;
}

void ViscousElements::advance(std::size_t element, const SymmetricMatrix3& elastic) {
  SymmetricMatrix3* const q = stresses_.data() + first_[place(element)];
  const SymmetricMatrix3 change = elastic + (-1.0) * q[0];
  q[0] = elastic;
  const std::vector<Term>& terms = series_[series_of(element)].terms;
  for (std::size_t i = 0; i < terms.size(); ++i)
    q[i + 1] = terms[i].decay * q[i + 1] + terms[i].stiffness * change;
}

void ViscousElements::set_stresses(std::span<const SymmetricMatrix3> stresses) {
  std::ranges::copy(stresses, stresses_.begin());
}

}  // namespace palpate::fem

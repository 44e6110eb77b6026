// Stiffness of smoothing domains.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "fem/grains.hpp"
#include "fem/plasticity.hpp"
#include "fem/smoothing_domains.hpp"
#include "fem/stress.hpp"
#include "fem/symmetric_eigen.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {

/// The derivative of a corotational stress by R: P = 2 mu R (S - I), or lambda tr(S - I) R, rotates with R.
/// Along the twist about principal axis k, [u_k]x R / sqrt 2, the second derivative of the energy is 2 mu (1
/// - 2 / (s_i + s_j)) for shape and 2 lambda tr(S - I) / (s_i + s_j) for volume (Smith, de Goes & Kim 2019,
/// section 4.1 for the first). Along all other directions it is that at fixed R. Negative ones are set to
/// zero. If stretches s of opposite signs cancel, the second is unbounded, so the sum is at least a half. An
/// ambient pressure p adds p s_k.
SmoothingDomains::Twists SmoothingDomains::twists_of(const ElementDeformation& d, double ambient) {
  constexpr double least_sum = 0.5;
  const auto [strains, axes] = symmetric_eigen(corotated_strain(d.gradient, d.rotation));
  const double volume = d.lambda * (strains.x + strains.y + strains.z);
  const Vec3 pairs{strains.y + strains.z, strains.x + strains.z, strains.x + strains.y};
  const auto root_of_half = [&](double pair, double strain) {
    const double elastic = (d.mu * pair + volume) / std::max(2.0 + pair, least_sum);
    return std::sqrt(std::max(0.0, elastic + 0.5 * ambient * (1.0 + strain)));
  };
  return {root_of_half(pairs.x, strains.x) * (d.rotation * axes[0]),
          root_of_half(pairs.y, strains.y) * (d.rotation * axes[1]),
          root_of_half(pairs.z, strains.z) * (d.rotation * axes[2])};
}

void SmoothingDomains::set_tangent(std::size_t domain, const Matrix3& h, const ElementDeformation& d) {
  if (d.hyperelastic) {
    if (is_volume(domain)) {
      set_volume_tangent(domain, h, d.law);
    } else {
      set_shape_tangent(domain, h, d.law);
    }
    return;
  }
  rotations_[domain] = d.rotation;
  const Twists twists = twists_of(d, ambient_[domain]);
  twist_stiffness_[domain] =
      scales_[domain] * outer_square(transposed(from_rows(twists[0], twists[1], twists[2])));
  const auto quad = [](const Vec3& a) {
    return simd::Quad{static_cast<float>(a.x), static_cast<float>(a.y), static_cast<float>(a.z), 0.0F};
  };
  const double scale = std::sqrt(scales_[domain] * modulus(domain));
  const double root = std::sqrt(scales_[domain]);
  for (std::uint32_t k = begin_[domain]; k < begin_[domain + 1]; ++k) {
    const Vec3 a = d.rotation * rest_gradients_[k];
    rotated_[k].strain = quad(scale * a);
    for (std::size_t n = 0; n < 3; ++n) rotated_[k].twist[n] = quad(root * cross(twists[n], a));
  }
}

/// A part of the pressure of volume dW/dJ has its term of dP/dF in the domains for shape: see
/// set_shape_tangent(). It is at most half the tension of active fibres (a muscle that contracts freely has a
/// third), since other pressures have other reasons.
void SmoothingDomains::set_volume_tangent(std::size_t domain, const Matrix3& h, HyperelasticLaw law) {
  constexpr double most = 0.5;
  const double pressure = law.bulk * volume_change(h, cofactors(h)) - law.rest_pressure();
  const double part = modulus(domain) / first_tet(domain).lambda;
  const double moved = std::clamp(-pressure, 0.0, most * part * laws_[domain].tension);
  law.ambient += moved;
  tangents_.set(domain, law, h, -moved);
}

/// The mean over the tets of a domain of what their domains for volume, from number `first` on, have `added`.
double SmoothingDomains::mean_added(std::size_t domain, std::size_t first) const {
  double sum = 0.0;
  double volume = 0.0;
  for (std::uint32_t k = tet_begin_[domain]; k < tet_begin_[domain + 1]; ++k) {
    const std::uint32_t tet = domain_tets_[k];
    const std::uint32_t* domains = &domain_of_tet_[domains_of_tet * tet];
    volume += tets_[tet].volume;
    for (std::size_t place = first; place < domains_of_tet; ++place) {
      if (domains[place] < size())
        sum += volume_fraction(place) * tets_[tet].volume * tangents_.added[domains[place]];
    }
  }
  return sum / volume;
}

/// The mean over the ends of the edge of a domain of what their domains have `added`.
double SmoothingDomains::mean_added_of_ends(std::size_t domain) const {
  const std::uint32_t first = domain_tets_[tet_begin_[domain]];
  const std::uint32_t* domains = &domain_of_tet_[domains_of_tet * first];
  const auto place = static_cast<std::size_t>(std::find(domains, domains + edges_of_tet, domain) - domains);
  double sum = 0.0;
  for (const std::size_t corner : SmoothedTet::edges[place]) {
    const std::uint32_t point = domains[edges_of_tet + corner];
    if (point < size()) sum += 0.5 * tangents_.added[point];
  }
  return sum;
}

/// Where active fibres pull, they and the shape have tension, and the volume has pressure. Each alone would
/// have negative eigenvalues or a large stiffness against turns, but together they cancel if tissue turns as
/// a whole. So domains for shape have the term of the pressure, with which they hardly have negative
/// eigenvalues. (Only a change of volume has one, -2 times the pressure without strain. It is small beside
/// lambda, and is made up for.)
///
/// The pressure does not cancel if tissue turns from one domain to the next. So domains for shape get c dF,
/// and those for volume -c dF, with their pressure c. The sum has no negative eigenvalues for points: their
/// gradient is the mean of those of their edges, and the square of a mean is at most the mean of the squares.
/// For patches this is not proven, but tested.
void SmoothingDomains::set_shape_tangent(std::size_t domain, const Matrix3& h, HyperelasticLaw law) {
  double added = 0.0;
  if (law.tension > 0.0) {
    const double pressure = mean_added(domain, edges_of_tet);
    const Matrix3 cofactor = cofactors(plus_identity(h));
    const double stiffer = -2.0 * pressure / std::max(inner(cofactor, cofactor), 1.0);
    law.bulk += stiffer;
    law.ambient += pressure - stiffer * volume_change(h, cofactors(h));
    added = -mean_added_of_ends(domain) - mean_added(domain, SmoothedTet::patch_place);
  }
  tangents_.set(domain, law, h, added);
}

/// The factor times V dP for a given dF.
Matrix3 SmoothingDomains::stress_change(std::size_t domain, const Matrix3& gradient) const {
  const double scale = scales_[domain];
  Matrix3 change;
  if (first_tet(domain).hyperelastic) {
    change = tangents_.stress_change(domain, laws_[domain].fibre, gradient);
    for (double& value : change.values) value *= scale;
    return change;
  }
  const Matrix3& r = rotations_[domain];
  const Matrix3 b = times_transposed(gradient, r);  // dF R^T
  const double modul = scale * modulus(domain);
  if (is_volume(domain)) {
    for (int k = 0; k < 3; ++k) change(k, k) = modul * trace(b);
  } else {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) change(i, j) = modul * (b(i, j) + b(j, i));
    }
  }
  const Vec3 w = twist_stiffness_[domain] * Vec3{b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1)};
  const Matrix3 turn = from_rows({0.0, -w.z, w.y}, {w.z, 0.0, -w.x}, {-w.y, w.x, 0.0});
  for (std::size_t k = 0; k < 9; ++k) change.values[k] += turn.values[k];
  return times_transposed(change, transposed(r));
}

/// The same for a part of the stiffness.
Matrix3 SmoothingDomains::stress_change(std::size_t domain, const Matrix3& gradient,
                                        StiffnessPart part) const {
  const double elastic = part == StiffnessPart::damping ? 0.0 : elastic_fractions_[domain];
  const double damping = part == StiffnessPart::elastic ? 0.0 : 1.0 - elastic_fractions_[domain];
  Matrix3 change = stress_change(domain, gradient);
  if (!is_held(domain)) {
    if (part == StiffnessPart::whole) return change;
    for (double& value : change.values) value *= elastic + damping;
    return change;
  }
  const Matrix3 held = held_tangents_.stress_change(domain, laws_[domain].fibre, gradient);
  for (std::size_t k = 0; k < 9; ++k)
    change.values[k] = elastic * change.values[k] + damping * scales_[domain] * held.values[k];
  return change;
}

void SmoothingDomains::prepare_blocks(const parallel::Threads& threads) const {
  if (tangents_.empty()) return;
  tangent_rows_.resize(size());
  parallel::for_each(threads, size(), domain_grain, [&](std::size_t domain) {
    if (!first_tet(domain).hyperelastic) return;
    for (std::size_t jd = 0; jd < 9; ++jd) {
      Matrix3 unit;
      unit.values[jd] = 1.0;
      const Matrix3 change = stress_change(domain, unit, StiffnessPart::whole);
      for (std::size_t ic = 0; ic < 9; ++ic)
        tangent_rows_[domain][3 * ic + jd % 3].values[jd / 3] = static_cast<float>(change.values[ic]);
    }
  });
}

Matrix3 SmoothingDomains::block_rest(std::size_t domain, const Matrix3& rotation, std::size_t i,
                                     std::size_t j) const {
  const Vec3 a = rotation * rest_gradients_[begin_[domain] + i];
  const Vec3 b = rotation * rest_gradients_[begin_[domain] + j];
  const double scale = scales_[domain] * modulus(domain);
  Matrix3 block;
  if (is_volume(domain)) {
    add_outer(block, scale, a, b);
    return block;
  }
  add_outer(block, scale, b, a);
  for (int k = 0; k < 3; ++k) block(k, k) += scale * dot(a, b);
  return block;
}

}  // namespace palpate::fem

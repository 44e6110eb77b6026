#include "fem/tense_elements.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <ranges>

#include "fem/symmetric_eigen.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

/// Tension at which geometric stiffness begins, over d sqrt(E rho) / h; see the class.
constexpr double onset_of_tension = 1.0;

/// Energy per volume over mu from which on an element is torn; twice as much has no geometric stiffness.
constexpr double torn_energy = 4.0;

/// Number of edges between each point and the nearest surface point; -1 for points without tets. `order`:
/// points of tets, from the surface inwards.
std::vector<Index> levels_below_surface(const Bodies& bodies, std::vector<Index>& order) {
  std::vector<Index> level(bodies.points_rest().size(), -1);
  for (const Triangle& triangle : bodies.triangles()) {
    for (const Index point : triangle) {
      if (at(level, point) < 0) order.push_back(point);
      at(level, point) = 0;
    }
  }
  for (std::size_t next = 0; next < order.size(); ++next) {
    for (const Index edge : bodies.point_edges()[order[next]]) {
      const Index other = bodies.other_end(edge, order[next]);
      if (at(level, other) >= 0) continue;
      at(level, other) = at(level, order[next]) + 1;
      order.push_back(other);
    }
  }
  return level;
}

/// The least height of a tet at rest, m.
double least_height(const Bodies& bodies, const Tet& tet) {
  const auto x = [&](std::size_t corner) { return at(bodies.points_rest(), tet[corner]); };
  const double six_volumes = dot(cross(x(1) - x(0), x(2) - x(0)), x(3) - x(0));
  double twice_area = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Vec3& first = x((k + 1) % 4);
    twice_area = std::max(twice_area, length(cross(x((k + 2) % 4) - first, x((k + 3) % 4) - first)));
  }
  return std::abs(six_volumes) / twice_area;
}

}  // namespace

std::vector<double> tissue_thickness(const Bodies& bodies) {
  std::vector<Index> order;
  const std::vector<Index> level = levels_below_surface(bodies, order);
  std::vector<Index> innermost = level;
  for (const Index point : std::views::reverse(order)) {
    for (const Index edge : bodies.point_edges()[point]) {
      const Index other = bodies.other_end(edge, point);
      if (at(level, other) > at(level, point))
        at(innermost, point) = std::max(at(innermost, point), at(innermost, other));
    }
  }
  std::vector<double> thickness;
  for (const Tet& tet : bodies.tets()) {
    Index most = 0;
    for (const Index corner : tet) most = std::max(most, at(innermost, corner));
    thickness.push_back((1 + 2 * most) * least_height(bodies, tet));
  }
  return thickness;
}

void TenseElements::add(double thickness, const Material& material, double volume) {
  const double nu = material.poisson_ratio;
  const double mu = material.young_modulus / (2.0 * (1.0 + nu));
  const double bulk = material.young_modulus / (1.0 - 2.0 * nu);  // 2 mu + 3 lambda
  scale_.push_back(onset_of_tension * thickness * std::sqrt(material.young_modulus * material.density));
  stiffness_.push_back(8.0 * bulk / volume);
  mu_.push_back(mu);
  least_energy_.push_back(std::numeric_limits<double>::infinity());
}

/// The energy V S : C^-1 S / 2 is at least V |S|^2 / (2 (2 mu + 3 lambda)), and two principal stresses have
/// a sum of at most 2 |S|.
void TenseElements::set_time_step(double time_step) {
  if (time_step == time_step_) return;
  time_step_ = time_step;
  for (std::size_t e = 0; e < scale_.size(); ++e) {
    const double least = scale_[e] / time_step;
    least_energy_[e] = least * least / stiffness_[e];
  }
}

void TenseElements::add_if_tense(std::size_t element, const SymmetricMatrix3& stress, double energy,
                                 std::vector<Tense>& tense) const {
  const double trace = stress.xx + stress.yy + stress.zz;
  const SymmetricEigen pairs =
      symmetric_eigen(SymmetricMatrix3{trace, trace, trace, 0.0, 0.0, 0.0} + -1.0 * stress);
  const double excess = pairs.values.x * time_step_ / scale_[element] - 1.0;
  if (!(excess > 0.0)) return;
  const double torn = energy / (torn_energy * mu_[element]);
  const double onset = std::min(1.0, excess) * std::clamp(2.0 - torn, 0.0, 1.0);
  if (onset == 0.0) return;
  tense.push_back({static_cast<Index>(element), onset / (4.0 * mu_[element]) * positive_part(pairs)});
}

void TenseElements::take(const parallel::Threads& threads, parallel::ChunkedList<Tense>& lists) {
  lists.join(threads, tense_);
}

std::span<const TenseElements::Tense> TenseElements::among(std::size_t begin, std::size_t end) const {
  const auto first = std::ranges::lower_bound(tense_, static_cast<Index>(begin), {}, &Tense::element);
  const auto last = std::ranges::lower_bound(tense_, static_cast<Index>(end), {}, &Tense::element);
  return {first, last};
}

const TenseElements::Tense* TenseElements::find(Index element) const {
  const auto place = std::ranges::lower_bound(tense_, element, {}, &Tense::element);
  return place != tense_.end() && place->element == element ? &*place : nullptr;
}

Matrix3 geometric_block(const SymmetricMatrix3& q, const Vec3& a, const Vec3& b) {
  const Vec3 x = cross(q * cross(b, {1, 0, 0}), a);
  const Vec3 y = cross(q * cross(b, {0, 1, 0}), a);
  const Vec3 z = cross(q * cross(b, {0, 0, 1}), a);
  return transposed(from_rows(x, y, z));
}

}  // namespace palpate::fem

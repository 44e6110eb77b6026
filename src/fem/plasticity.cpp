#include "fem/plasticity.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/vector.hpp"

namespace palpate::fem {
namespace {

double inner(const SymmetricMatrix3& a, const SymmetricMatrix3& b) {
  return a.xx * b.xx + a.yy * b.yy + a.zz * b.zz + 2.0 * (a.xy * b.xy + a.xz * b.xz + a.yz * b.yz);
}

double trace(const SymmetricMatrix3& a) {
  return a.xx + a.yy + a.zz;
}

double energy_density(const SymmetricMatrix3& elastic, double mu, double lambda) {
  return mu * inner(elastic, elastic) + 0.5 * lambda * trace(elastic) * trace(elastic);
}

/// vee(a b - b a): the axis of the commutator, which is antisymmetric.
Vec3 commutator_axis(const SymmetricMatrix3& a, const SymmetricMatrix3& b) {
  // (a b)_ij - (a b)_ji, by rows of a and columns of b.
  const Vec3 ax{a.xx, a.xy, a.xz};
  const Vec3 ay{a.xy, a.yy, a.yz};
  const Vec3 az{a.xz, a.yz, a.zz};
  const Vec3 bx{b.xx, b.xy, b.xz};
  const Vec3 by{b.xy, b.yy, b.yz};
  const Vec3 bz{b.xz, b.yz, b.zz};
  return {dot(az, by) - dot(ay, bz), dot(ax, bz) - dot(az, bx), dot(ay, bx) - dot(ax, by)};
}

}  // namespace

double norm(const SymmetricMatrix3& a) {
  return std::sqrt(inner(a, a));
}

SymmetricMatrix3 corotated_strain(const Matrix3& f, const Matrix3& rotation) {
  return symmetric_part(transposed_times(rotation, f - rotation));
}

SymmetricMatrix3 plastic_flow(const SymmetricMatrix3& plastic, const SymmetricMatrix3& total,
                              const Plasticity& plasticity, double time_step, double mu, double lambda) {
  const SymmetricMatrix3 elastic = total + (-1.0) * plastic;
  if (!plasticity.yield || !(norm(elastic) > *plasticity.yield)) return plastic;
  SymmetricMatrix3 next = plastic + std::min(1.0, time_step * plasticity.creep) * elastic;
  const double size = norm(next);
  if (plasticity.maximum && size > *plasticity.maximum) next = (*plasticity.maximum / size) * next;
  const bool gives_energy =
      energy_density(total + (-1.0) * next, mu, lambda) > energy_density(elastic, mu, lambda);
  return gives_energy ? plastic : next;
}

Vec3 plastic_twist(const SymmetricMatrix3& stretch, const SymmetricMatrix3& plastic) {
  const Vec3 axis = commutator_axis(stretch, plastic);
  if (axis == Vec3{}) return {};
  const double t = trace(stretch);
  const Matrix3 g{{t - stretch.xx, -stretch.xy, -stretch.xz, -stretch.xy, t - stretch.yy, -stretch.yz,
                   -stretch.xz, -stretch.yz, t - stretch.zz}};
  const Vec3 w = inverse(g) * axis;
  if (!is_finite(w)) return {};
  const double most = norm(plastic) / std::numbers::sqrt2;
  const double size = length(w);
  return size > most ? (most / size) * w : w;
}

Vec3 twist_of(const Matrix3& f, const Matrix3& rotation, const SymmetricMatrix3& plastic) {
  const SymmetricMatrix3 unit{1.0, 1.0, 1.0, 0.0, 0.0, 0.0};
  return plastic_twist(unit + corotated_strain(f, rotation), plastic);
}

}  // namespace palpate::fem

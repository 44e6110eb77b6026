#include "fem/stress.hpp"

#include <cmath>
#include <limits>

namespace palpate::fem {
namespace {

/// (F^T F - I) / 2 from H = F - I, without cancellation near rest.
SymmetricMatrix3 green_strain(const Matrix3& f) {
  const Matrix3 h = f - identity();
  SymmetricMatrix3 e = symmetric_part(h);
  const auto column = [&](int k) { return Vec3{h(0, k), h(1, k), h(2, k)}; };
  e.xx += 0.5 * dot(column(0), column(0));
  e.yy += 0.5 * dot(column(1), column(1));
  e.zz += 0.5 * dot(column(2), column(2));
  e.xy += 0.5 * dot(column(0), column(1));
  e.xz += 0.5 * dot(column(0), column(2));
  e.yz += 0.5 * dot(column(1), column(2));
  return e;
}

/// First Piola-Kirchhoff stress of the corotational law.
Matrix3 derivative_of_energy(const ElementDeformation& e) {
  const double spherical = e.lambda * inner(e.rotation, e.stretch);
  Matrix3 p;
  for (int i = 0; i < 3; ++i) {
    // Row i of R [w]_x is row i of R, times [w]_x: r x w.
    const Vec3 r = row(e.rotation, i);
    const Vec3 twisted = cross(r, e.twist);
    p(i, 0) = 2.0 * e.mu * (e.stretch(i, 0) - twisted.x) + spherical * r.x;
    p(i, 1) = 2.0 * e.mu * (e.stretch(i, 1) - twisted.y) + spherical * r.y;
    p(i, 2) = 2.0 * e.mu * (e.stretch(i, 2) - twisted.z) + spherical * r.z;
  }
  return p;
}

HyperelasticResponse corotational(const ElementDeformation& e) {
  const double trace = inner(e.rotation, e.stretch);
  return {e.mu * inner(e.stretch, e.stretch) + 0.5 * e.lambda * trace * trace, derivative_of_energy(e)};
}

}  // namespace

HyperelasticResponse elastic_response(const ElementDeformation& e) {
  return e.hyperelastic ? respond(e.law, e.gradient - identity()) : corotational(e);
}

HyperelasticResponse whole_response(const ElementDeformation& e) {
  HyperelasticResponse response = elastic_response(e);
  response.energy_density += e.viscous_energy;
  if (e.viscous_stress != SymmetricMatrix3{}) {
    const Matrix3 viscous = first_piola_stress(e.viscous_stress, e.gradient, e.rotation);
    for (std::size_t k = 0; k < 9; ++k) response.stress.values[k] += viscous.values[k];
  }
  return response;
}

SymmetricMatrix3 biot_stress(const ElementDeformation& element) {
  ElementDeformation passive = element;
  passive.law.tension = 0.0;
  return symmetric_part(transposed_times(element.rotation, elastic_response(passive).stress));
}

Matrix3 first_piola_stress(const SymmetricMatrix3& biot, const Matrix3& gradient, const Matrix3& rotation) {
  const Vec3 w = twist_of(gradient, rotation, biot);
  Matrix3 p;
  for (int i = 0; i < 3; ++i) {
    const Vec3 r = row(rotation, i);
    const Vec3 sum = biot * r + cross(r, w);
    p(i, 0) = sum.x;
    p(i, 1) = sum.y;
    p(i, 2) = sum.z;
  }
  return p;
}

double energy_density_of(const ElementDeformation& e) {
  return elastic_response(e).energy_density + e.viscous_energy;
}

ElementStress stress_of(const ElementDeformation& e) {
  return stress_of(e, whole_response(e));
}

ElementStress stress_of(const ElementDeformation& e, const HyperelasticResponse& response) {
  ElementStress s;
  s.deformation_gradient = e.gradient;
  s.strain = green_strain(e.gradient);
  s.plastic_strain = e.plastic_strain;
  s.volume_ratio = determinant(e.gradient);
  s.energy_density = response.energy_density;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const double scale = s.volume_ratio > 0.0 ? 1.0 / s.volume_ratio : none;
  s.stress = scale * symmetric_part(times_transposed(response.stress, e.gradient));
  return s;
}

double von_mises(const SymmetricMatrix3& s) {
  const double xy = s.xx - s.yy;
  const double yz = s.yy - s.zz;
  const double zx = s.zz - s.xx;
  const double shear = s.xy * s.xy + s.yz * s.yz + s.xz * s.xz;
  return std::sqrt(0.5 * (xy * xy + yz * yz + zx * zx) + 3.0 * shear);
}

}  // namespace palpate::fem

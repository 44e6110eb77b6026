#include "fem/lumping.hpp"

#include <cstddef>

#include "fem/matrix.hpp"
#include "fem/viscosity.hpp"
#include "geometry/vector.hpp"

namespace palpate::fem {
double tet_volume_rest(const Bodies& bodies, Index tet) {
  const Tet& corners = at(bodies.tets(), tet);
  const Vec3 origin = at(bodies.points_rest(), corners[0]);
  const Vec3 a = at(bodies.points_rest(), corners[1]) - origin;
  const Vec3 b = at(bodies.points_rest(), corners[2]) - origin;
  const Vec3 c = at(bodies.points_rest(), corners[3]) - origin;
  return determinant(Matrix3{{a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z}}) / 6.0;
}

std::vector<double> lumped_masses(const Bodies& bodies, const Materials& materials) {
  std::vector<double> masses(bodies.points_rest().size(), 0.0);
  for (Index body = 0; body < bodies.body_count(); ++body) {
    const Range tets = at(bodies.bodies(), body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      const Tet& corners = at(bodies.tets(), tet);
      const double volume = tet_volume_rest(bodies, tet);
      for (const Index point : corners) at(masses, point) += 0.25 * materials.of(tet, body).density * volume;
    }
  }
  return masses;
}

std::vector<double> mass_dampings(const Bodies& bodies, const Materials& materials,
                                  std::span<const double> masses) {
  std::vector<double> dampings(masses.size());
  for (std::size_t point = 0; point < masses.size(); ++point) {
    dampings[point] = at(materials.all, bodies.body_of_point()[point]).mass_damping;
  }
  if (materials.of_tet.empty()) return dampings;
  std::vector<double> changes(masses.size(), 0.0);  // differences from the body's own value, times mass
  for (Index body = 0; body < bodies.body_count(); ++body) {
    const Range tets = at(bodies.bodies(), body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      const Material& material = materials.of(tet, body);
      const double change = material.mass_damping - at(materials.all, body).mass_damping;
      const double quarter = 0.25 * material.density * tet_volume_rest(bodies, tet);
      for (const Index point : at(bodies.tets(), tet)) at(changes, point) += quarter * change;
    }
  }
  for (std::size_t point = 0; point < masses.size(); ++point) {
    if (changes[point] != 0.0) dampings[point] += changes[point] / masses[point];
  }
  return dampings;
}

std::vector<Material> mean_materials(const Bodies& bodies, const Materials& materials) {
  std::vector<Material> means(materials.all.begin(), materials.all.begin() + bodies.body_count());
  for (Material& mean : means) mean.young_modulus = instantaneous_modulus(mean);
  if (materials.of_tet.empty()) return means;
  for (Index body = 0; body < bodies.body_count(); ++body) {
    Material& mean = at(means, body);
    double modulus = 0.0;  // sums of differences from the body's own values, times volume
    double ratio = 0.0;
    double volume = 0.0;
    const Range tets = at(bodies.bodies(), body).tets;
    for (Index tet = tets.begin; tet < tets.end; ++tet) {
      const Material& material = materials.of(tet, body);
      const double own_volume = tet_volume_rest(bodies, tet);
      modulus += own_volume * (instantaneous_modulus(material) - mean.young_modulus);
      ratio += own_volume * (material.poisson_ratio - mean.poisson_ratio);
      volume += own_volume;
    }
    if (modulus != 0.0) mean.young_modulus += modulus / volume;
    if (ratio != 0.0) mean.poisson_ratio += ratio / volume;
  }
  return means;
}

}  // namespace palpate::fem

// Nearly incompressible tissue that starts far stretched: the first steps converge and gain no energy.
// Oracle: the potential that a step of implicit Euler minimises, from tissue() and the masses of points.
#include <gtest/gtest.h>
#include <vector>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate::test {
namespace {

struct Start {
  Vec3 stretch;
  MaterialModel model = MaterialModel::stable_neo_hookean;
};

/// A ball that turns, stretched by different factors along x, y and z.
Simulation stretched_ball(const Start& start, const Material& material, double time_step) {
  SimulationSettings settings;
  settings.time_step = time_step;
  settings.gravity = {};
  Simulation simulation({.bodies = single_body(ball_mesh(4, {}, 0.03)), .materials = {material}}, settings,
                        1);
  std::vector<Index> points;
  std::vector<Vec3> positions;
  std::vector<Vec3> velocities;
  for (const Vec3& p : simulation.positions()) {
    points.push_back(static_cast<Index>(points.size()));
    positions.push_back({start.stretch.x * p.x, start.stretch.y * p.y, start.stretch.z * p.z});
    velocities.push_back(cross({3.0, 1.0, -4.0}, positions.back()));
  }
  simulation.set_positions(points, positions);
  simulation.set_velocities(points, velocities);
  return simulation;
}

double elastic_energy(const Simulation& simulation) {
  const TissueState tissue = simulation.tissue();
  const Bodies& bodies = simulation.bodies();
  double sum = 0.0;
  for (std::size_t t = 0; t < tissue.size(); ++t) {
    const Tet& tet = bodies.tets()[t];
    const auto edge = [&](std::size_t k) {
      return at(bodies.points_rest(), tet[k]) - at(bodies.points_rest(), tet[0]);
    };
    sum += tissue.energy_density[t] * dot(edge(1), cross(edge(2), edge(3))) / 6.0;
  }
  return sum;
}

/// Sum of m |v - before|^2 / 2.
double energy_of_change(const Simulation& simulation, const std::vector<Vec3>& before) {
  double sum = 0.0;
  for (std::size_t i = 0; i < before.size(); ++i)
    sum += 0.5 * simulation.point_masses()[i] * squared_length(simulation.velocities()[i] - before[i]);
  return sum;
}

/// Returns whether the first step is not divided.
bool expect_convergence(const Start& start, const Material& material, double time_step) {
  SCOPED_TRACE(::testing::Message() << start.stretch.x << ", " << static_cast<int>(material.model) << ", "
                                    << material.young_modulus << " Pa, " << material.poisson_ratio << ", "
                                    << time_step);
  Simulation simulation = stretched_ball(start, material, time_step);
  const std::vector<Vec3> before(simulation.velocities().begin(), simulation.velocities().end());
  const double energy =
      elastic_energy(simulation) + energy_of_change(simulation, std::vector<Vec3>(before.size()));
  simulation.step();
  EXPECT_TRUE(simulation.metrics().solver_converged);
  EXPECT_EQ(simulation.metrics().inverted_tets, 0);
  if (simulation.metrics().substeps > 1) return false;
  EXPECT_LT(elastic_energy(simulation) + energy_of_change(simulation, before), energy);
  return true;
}

TEST(StretchedStarts, ConvergeInWholeStepsAndGainNoEnergy) {
  int whole = 0;
  for (const Start& start : {Start{{1.3, 0.85, 0.95}}, Start{{1.5, 0.9, 0.9}},
                             Start{{1.3, 0.85, 0.95}, MaterialModel::mooney_rivlin}}) {
    for (const double young_modulus : {1e5, 1e6, 1e7}) {
      for (const double poisson_ratio : {0.45, 0.49, 0.499}) {
        const Material material{
            .young_modulus = young_modulus, .poisson_ratio = poisson_ratio, .model = start.model};
        for (const double time_step : {0.01, 0.04})
          whole += expect_convergence(start, material, time_step) ? 1 : 0;
      }
    }
  }
  EXPECT_GE(whole, 52) << "of 54";
}

}  // namespace
}  // namespace palpate::test

#include "scene/own_weight.hpp"

#include <cmath>
#include <cstddef>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"

namespace palpate {

double sag_under_own_weight(const Bodies& bodies, const Material& material,
                            const std::vector<std::uint8_t>& fixed) {
  // The tissue is so stiff that the body hardly rotates, and the step is so long that inertia does not
  // matter. So one step reaches the state at rest.
  constexpr double stiffer = 1e6;
  Material stiff = material;
  stiff.young_modulus *= stiffer;
  stiff.mass_damping = 0.0;
  stiff.stiffness_damping = 0.0;
  SimulationSettings settings;
  settings.time_step = 1.0;
  // The error that `solution` bounds is relative to a free fall of that duration.
  settings.solver.tolerance_of = ToleranceOf::residual;
  settings.solver.tolerance = 1e-6;
  settings.solver.max_iterations = 3000;
  settings.solver.preconditioner = Preconditioner::multigrid;
  Simulation simulation({.bodies = bodies, .materials = {stiff}, .fixed_points = fixed}, settings, 1);
  simulation.step();
  double squares = 0.0;
  double mass = 0.0;
  for (std::size_t point = 0; point < bodies.points_rest().size(); ++point) {
    const double weight = simulation.point_masses()[point];
    squares += weight * squared_length(simulation.positions()[point] - bodies.points_rest()[point]);
    mass += weight;
  }
  return stiffer * std::sqrt(squares / mass);
}

}  // namespace palpate

#include "our_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"

namespace palpate::bench {

OurDynamics::OurDynamics(const Bodies& bodies, const Material& material,
                         std::vector<std::uint8_t> free_points, std::span<const double> point_masses)
    : free(std::move(free_points)),
      masses(point_masses.begin(), point_masses.end()),
      elements(bodies, std::vector<Material>(static_cast<std::size_t>(bodies.body_count()), material),
               std::vector<std::uint8_t>(static_cast<std::size_t>(bodies.body_count()), 0)),
      matrix(elements, free),
      system(matrix, couplings, free),
      multigrid(matrix),
      right_side(free.size()),
      solution(free.size()) {
  const double scale = time_step * (material.stiffness_damping + time_step);
  elements.set_factors(std::vector<double>(static_cast<std::size_t>(elements.size()), scale));
  couplings.set(parallel::Threads(1), {}, time_step, free);
}

void OurDynamics::update(const parallel::Threads& threads, std::span<const Vec3> positions) {
  elements.update(threads, positions);
  matrix.assemble(threads, masses);
  const auto elastic = elements.point_forces();
  for (std::size_t p = 0; p < free.size(); ++p) {
    if (free[p] == 0) continue;
    const simd::Padded3& f = elastic[p];
    const Vec3 force = masses[p] * gravity + Vec3{f.x, f.y, f.z};
    right_side[p] = {time_step * force.x, time_step * force.y, time_step * force.z, 0.0};
  }
}

fem::SolveReport OurDynamics::solve(Preconditioner preconditioner, double goal,
                                    std::span<const Vec3> positions) {
  const parallel::Threads one_thread(1);
  std::fill(solution.begin(), solution.end(), simd::Padded3{});
  system.update_preconditioner(one_thread);
  const fem::SolveReport report = solver.solve(one_thread, system, right_side, solution,
                                               {.tolerance = goal,
                                                .max_iterations = 100000,
                                                .of_solution = true,
                                                .preconditioner = preconditioner,
                                                .jacobi_iterations = jacobi_iterations},
                                               &multigrid, positions);
  if (preconditioner == Preconditioner::automatic) jacobi_iterations = report.jacobi_iterations;
  return report;
}

/// A bent and twisted shape, another for each frame.
std::vector<Vec3> deformed(std::span<const Vec3> rest, int frame) {
  Vec3 lower = rest[0];
  Vec3 upper = rest[0];
  for (const Vec3& p : rest) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
  const double size = std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z});
  std::vector<Vec3> positions;
  for (const Vec3& p : rest) {
    const Vec3 u = (6.28 / size) * (p - lower);
    const double t = 0.15 * frame;
    const double a = 0.004 * size;
    positions.push_back(p + a * Vec3{std::sin(u.y + 0.7 * u.z + t), std::sin(u.z + t) * std::cos(0.6 * u.x),
                                     0.6 * std::cos(u.x + 1.3 * u.y - t)});
  }
  return positions;
}

}  // namespace palpate::bench

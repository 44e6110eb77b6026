// A plate presses a soft block until it feels 2 N, and holds there. In C++ the callback of each step is the
// body of the loop that calls step(): it may read everything and change everything.
#include <cstdio>
#include <utility>

#include <palpate/palpate.hpp>

namespace {

constexpr double young_modulus = 20e3;  // Pa
constexpr double width = 0.1;           // m, of the block
constexpr double height = 0.05;         // m

/// A box of n x n x n cells, six tets each, on a square of a given width about the z axis.
palpate::TetMesh box(int n, double side, double from, double to) {
  palpate::TetMesh mesh;
  const auto along = [n](double low, double high, int i) { return low + (high - low) * i / n; };
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i)
        mesh.points.push_back(
            {along(-side / 2, side / 2, i), along(-side / 2, side / 2, j), along(from, to, k)});
  const int x = 1;
  const int y = n + 1;
  const int z = y * y;
  const std::pair<int, int> corners[] = {{x, x + y}, {x, x + z}, {y, x + y},
                                         {y, y + z}, {z, x + z}, {z, y + z}};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const int corner = i + y * j + z * k;
        for (const auto& [first, second] : corners)
          mesh.tets.push_back({corner, corner + first, corner + second, corner + x + y + z});
      }
  return mesh;
}

/// What happens before each step: the plate goes down by 10 micrometres where it feels less than 2 N.
void drive(palpate::Simulation& simulation, double& shift) {
  if (simulation.contact_wrench(1).force.z < 2.0) shift -= 1e-5;
  simulation.move_to(0, {.time = 0.0, .translate = {0.0, 0.0, shift}, .quaternion = {1.0, 0.0, 0.0, 0.0}});
}

}  // namespace

int main() try {
  palpate::Model model;
  model.bodies.add("block", box(4, width, 0.0, height));
  model.bodies.add("plate", box(1, 1.2 * width, height, height + 0.01));
  model.materials = {
      {.young_modulus = young_modulus, .poisson_ratio = 0.0, .mass_damping = 20.0, .stiffness_damping = 5e-3},
      {}};
  model.obstacles = {0, 1};
  model.motions = {{{}, {{0.0, {}, {1.0, 0.0, 0.0, 0.0}}}}};
  for (const palpate::Vec3& point : model.bodies.points_rest()) {
    model.fixed_points.push_back(point.z == 0.0 ? 1 : 0);
    model.motion_of_point.push_back(-1);
  }
  const palpate::Range plate = model.bodies.bodies()[1].points;
  for (palpate::Index p = plate.begin; p < plate.end; ++p)
    model.motion_of_point[static_cast<std::size_t>(p)] = 0;

  palpate::SimulationSettings settings;
  settings.gravity = {};
  palpate::Simulation simulation(std::move(model), settings);
  double shift = 0.0;
  while (simulation.metrics().step < 500) {
    drive(simulation, shift);
    simulation.step();
  }

  double top = 0.0;  // mean height of the loaded face
  int count = 0;
  for (std::size_t p = 0; p < static_cast<std::size_t>(plate.begin); ++p) {
    if (simulation.bodies().points_rest()[p].z < height) continue;
    top += simulation.positions()[p].z;
    ++count;
  }
  const double strain = 1.0 - top / count / height;
  std::printf("force %.2f N, by Hooke's law %.2f N\n", simulation.contact_wrench(1).force.z,
              young_modulus * width * width * strain);
  return 0;
} catch (const palpate::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

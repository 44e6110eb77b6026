// The default tolerance of the solver is small enough: runs end where runs of a far smaller tolerance do.
#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "sim/examples.hpp"

namespace palpate::test {
namespace {

std::vector<Vec3> positions_at_start(const Scene& scene) {
  const Simulation simulation = simulate(scene);
  return {simulation.positions().begin(), simulation.positions().end()};
}

/// Examples but for the liver, which takes long, and for fold, plastic and regions: there many states of
/// friction are at rest, and the one that a run ends in depends on rounding (docs/solver.md).
class DefaultTolerance : public testing::TestWithParam<std::string> {};

/// The goal of the default: final positions within 1e-3 of the mean edge length, and within 1e-4 of the path
/// of a point that slides far.
TEST_P(DefaultTolerance, EndsWhereAFarSmallerOneDoes) {
  constexpr double of_edge = 1e-3;
  constexpr double of_path = 1e-4;
  constexpr double reference_tolerance = 1e-9;
  Scene scene = example(GetParam());
  const std::vector<Vec3> start = positions_at_start(scene);
  const Simulation simulation = run(scene);
  scene.settings.solver.tolerance = reference_tolerance;
  const Simulation reference = run(scene);
  const Bodies& bodies = reference.bodies();
  const double edge = mesh_statistics(bodies, bodies.points_rest()).edge_length.mean;
  bool differs = false;
  for (std::size_t p = 0; p < start.size(); ++p) {
    const Vec3& expected = reference.positions()[p];
    const double error = length(simulation.positions()[p] - expected);
    ASSERT_LE(error, of_edge * edge + of_path * length(expected - start[p])) << "point " << p;
    differs = differs || error > 0.0;
  }
  EXPECT_TRUE(differs) << "the reference has the same tolerance";
}

INSTANTIATE_TEST_SUITE_P(Examples, DefaultTolerance,
                         testing::Values("attached", "belt", "crossed-bars", "everything", "grab",
                                         "incline-slide", "incline-stick", "jaw", "load", "muscle", "needle",
                                         "press", "tower", "two-stiffnesses"),
                         [](const auto& instance) {
                           std::string name = instance.param;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace palpate::test

// Aligned boxes of a few cells lie on each other, flush or almost. Oracle: surfaces that rest on each other
// are where each other are; a column stands that is stiffer than the one that buckles under its own weight.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

constexpr double box_size = 0.1;

/// Boxes on each other, the lowest one on z = 0 at rest.
struct Column {
  int boxes;
  int cells;             ///< along each side
  double offset;         ///< of each box from the one below, along x; half of it along y, m
  double young_modulus;  ///< Pa
  double time_step;      ///< s
  bool on_obstacle;      ///< the lowest box is rigid; otherwise its lower face is fixed
};

std::string text_of(const Column& c) {
  return std::to_string(c.boxes) + " boxes, " + std::to_string(c.cells) + " cells, offset " +
         std::to_string(c.offset) + ", E " + std::to_string(c.young_modulus) + ", step " +
         std::to_string(c.time_step) + (c.on_obstacle ? ", on an obstacle" : "");
}

/// A column after some seconds.
Simulation stand(const Column& column, double seconds) {
  Model model;
  for (int b = 0; b < column.boxes; ++b) {
    const Vec3 corner{b * column.offset, 0.5 * b * column.offset, b * box_size};
    model.bodies.add("box", test::box_mesh({column.cells, column.cells, column.cells}, corner,
                                           corner + Vec3{box_size, box_size, box_size}));
  }
  model.materials.assign(model.bodies.bodies().size(), Material{.young_modulus = column.young_modulus});
  model.obstacles.assign(model.bodies.bodies().size(), 0);
  model.obstacles[0] = column.on_obstacle ? 1 : 0;
  if (!column.on_obstacle) {
    for (const Vec3& p : model.bodies.points_rest()) model.fixed_points.push_back(p.z == 0.0 ? 1 : 0);
  }
  SimulationSettings settings;
  settings.time_step = column.time_step;
  settings.response.friction = 0.5;
  Simulation simulation(std::move(model), settings, 1);
  const int steps = static_cast<int>(std::lround(seconds / column.time_step));
  for (int step = 0; step < steps; ++step) simulation.step();
  return simulation;
}

/// Mean position of the points of a body that are at a height at rest.
Vec3 mean_at(const Simulation& simulation, Index body, double height) {
  const Range points = at(simulation.bodies().bodies(), body).points;
  Vec3 sum{};
  int count = 0;
  for (Index p = points.begin; p < points.end; ++p) {
    if (std::abs(at(simulation.bodies().points_rest(), p).z - height) > 1e-6) continue;
    sum += at(simulation.positions(), p);
    ++count;
  }
  return (1.0 / count) * sum;
}

/// That each box lies on the one below, within 1 % of a cell, and is not further from its place along it.
/// \param most  m
void expect_on_each_other(const Simulation& simulation, const Column& column, double most) {
  for (Index b = 1; b < simulation.bodies().body_count(); ++b) {
    const double height = b * box_size;
    const Vec3 apart = mean_at(simulation, b, height) - mean_at(simulation, b - 1, height);
    EXPECT_NEAR(apart.z, 0.0, 0.01 * box_size / column.cells) << text_of(column) << ", box " << b;
    EXPECT_NEAR(apart.x, column.offset, most) << text_of(column) << ", box " << b;
    EXPECT_NEAR(apart.y, 0.5 * column.offset, most) << text_of(column) << ", box " << b;
  }
}

/// All combinations, or one of `every`.
int rest_on_each_other(int every) {
  int number = 0;
  int done = 0;
  for (const int cells : {1, 2}) {
    for (const double offset : {0.0, 1e-4, 1e-3, 5e-3}) {
      for (const double young_modulus : {3e4, 1e5, 1e6, 1e7, 1e8}) {
        for (const double time_step : {0.001, 0.005, 0.01, 0.02}) {
          for (const bool on_obstacle : {true, false}) {
            if (number++ % every != every / 2) continue;
            const Column column{2, cells, offset, young_modulus, time_step, on_obstacle};
            expect_on_each_other(stand(column, 1.0), column, 5e-4);
            ++done;
          }
        }
      }
    }
  }
  return done;
}

TEST(Aligned, TwoBoxesRestAtAnyOffsetStiffnessAndTimeStep) {
  EXPECT_EQ(rest_on_each_other(9), 36);
}

TEST(Aligned, DISABLED_TwoBoxesRestInAllCombinations) {
  EXPECT_EQ(rest_on_each_other(1), 320);
}

/// A column of height L, area A and second moment I buckles under its own weight at L^3 = 7.84 E I / (rho g
/// A) (Greenhill, 1881): here, a column of one piece does with E = 1.5 MPa.
int towers(int every, int most_cells) {
  int number = 0;
  int done = 0;
  for (int cells = 1; cells <= most_cells; cells *= 2) {
    for (const double young_modulus : {2e6, 3e6, 1e7, 1e8}) {
      for (const double time_step : {0.001, 0.005, 0.01, 0.02}) {
        if (number++ % every != every / 2) continue;
        const Column column{10, cells, 0.0, young_modulus, time_step, true};
        const Simulation simulation = stand(column, 2.0);
        expect_on_each_other(simulation, column, 5e-4);
        const Vec3 top = mean_at(simulation, 9, 10 * box_size);
        EXPECT_NEAR(top.x, 0.5 * box_size, 0.002) << text_of(column);
        EXPECT_NEAR(top.y, 0.5 * box_size, 0.002) << text_of(column);
        ++done;
      }
    }
  }
  return done;
}

TEST(Aligned, TowersOfTenStandThatAreStifferThanTheOneThatBuckles) {
  EXPECT_EQ(towers(9, 2), 4);
}

TEST(Aligned, DISABLED_TowersOfTenStandInAllCombinations) {
  EXPECT_EQ(towers(1, 4), 48);
}

}  // namespace
}  // namespace palpate

#pragma once

#include <gtest/gtest.h>
#include <span>

#include <palpate/simulation.hpp>

#include "geometry/vector.hpp"

namespace palpate::test {

inline constexpr double g = 9.81;

inline Vec3 sum_of(std::span<const Vec3> values) {
  Vec3 sum;
  for (const Vec3& v : values) sum += v;
  return sum;
}

inline void run_to_rest(Simulation& simulation, int most) {
  while (!simulation.at_rest() && simulation.metrics().step < most) simulation.step();
  ASSERT_TRUE(simulation.at_rest()) << "fastest body " << simulation.metrics().fastest_body;
}

/// Solves up to rounding.
inline SimulationSettings exact_settings() {
  SimulationSettings settings;
  settings.solver.tolerance = 1e-10;
  settings.solver.max_iterations = 5000;
  return settings;
}

}  // namespace palpate::test

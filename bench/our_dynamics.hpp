#pragma once

#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/conjugate_gradients.hpp"

namespace palpate::bench {

/// The system of a step from rest and its solution, as a step runs them: elements, matrix, preconditioners.
/// No contacts.
struct OurDynamics {
  static constexpr double time_step = 0.01;
  static constexpr Vec3 gravity{0.0, 0.0, -9.81};

  /// \param free_points, point_masses  per point
  OurDynamics(const Bodies& bodies, const Material& material, std::vector<std::uint8_t> free_points,
              std::span<const double> point_masses);
  /// Rotations, forces and matrix at these positions.
  void update(const parallel::Threads& threads, std::span<const Vec3> positions);
  /// To a relative error of the solution, from zero, in one thread.
  fem::SolveReport solve(Preconditioner preconditioner, double goal, std::span<const Vec3> positions);

  std::vector<std::uint8_t> free;
  std::vector<double> masses;
  fem::Elements elements;
  fem::BlockMatrix matrix;
  fem::CouplingSystem couplings;
  fem::LinearSystem system;
  fem::Multigrid multigrid;
  int jacobi_iterations = 0;
  fem::ConjugateGradients solver;
  std::vector<simd::Padded3> right_side;
  std::vector<simd::Padded3> solution;
};

/// A bent and twisted shape, another for each frame.
std::vector<Vec3> deformed(std::span<const Vec3> rest, int frame);

}  // namespace palpate::bench

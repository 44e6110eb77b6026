#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "fem/conjugate_gradients.hpp"
#include "fem/linear_system.hpp"
#include "fem/meshes.hpp"

namespace palpate::fem::test {

inline constexpr double time_step = 0.01;

inline SymmetricMatrix3 random_semi_definite(std::mt19937_64& random, double scale) {
  const Vec3 a = random_vector(random, 1.0);
  const Vec3 b = random_vector(random, 1.0);
  const auto outer = [&](const Vec3& v) {
    return scale * SymmetricMatrix3{v.x * v.x, v.y * v.y, v.z * v.z, v.x * v.y, v.x * v.z, v.y * v.z};
  };
  return outer(a) + outer(b);
}

/// A deformed box with couplings and fixed points, and the same system written out densely by other means.
struct System {
  /// \param held  at x = 0; else only couplings hold it
  explicit System(int thread_count, bool held = true)
      : threads(thread_count),
        bodies(single_body(irregular_box_mesh({4, 3, 3}, {0.4, 0.3, 0.3}, 0.2))),
        elements(bodies, std::vector<Material>(1, {5e4, 0.4, 1000.0, 0.0, 0.0}),
                 std::vector<std::uint8_t>(1, 0)),
        free(select(bodies, [&](const Vec3& p) { return !held || p.x > 0.0; })),
        matrix(elements, free),
        system(matrix, couplings, free) {
    std::mt19937_64 random(21);
    std::uniform_real_distribution<double> uniform(0.5, 2.0);
    for (std::size_t i = 0; i < free.size(); ++i) diagonal.push_back(uniform(random));
    for (Index e = 0; e < elements.size(); ++e) factors.push_back(1e-4 * uniform(random));
    elements.set_factors(factors);
    elements.update(threads, noisy(bodies, 0.02, 20));
    matrix.assemble(threads, diagonal);
    std::uniform_int_distribution<Index> any(0, 10);
    for (int c = 0; c < 600; ++c) {
      Coupling coupling;
      const int used = c % 7 == 0 ? 1 : 5;
      for (int k = 0; k < used; ++k) {
        // Distinct points, some of them fixed.
        at(coupling.points, k) = 16 * k + any(random);
        at(coupling.coefficients, k) = k == 0 ? 1.0 : -uniform(random) / 4.0;
      }
      coupling.stiffness = random_semi_definite(random, 2000.0);
      coupling.damping = random_semi_definite(random, 3.0);
      coupling.force = random_vector(random, 1.0);
      list.push_back(coupling);
    }
    couplings.set(parallel::Threads(1), list, time_step, free);
    system.update_preconditioner(threads);
  }

  [[nodiscard]] Eigen::MatrixXd dense() const {
    const auto n = 3 * static_cast<Eigen::Index>(free.size());
    Eigen::MatrixXd a = dense_stiffness(elements, free.size());
    for (std::size_t i = 0; i < free.size(); ++i) {
      a.diagonal().segment<3>(3 * static_cast<Eigen::Index>(i)).array() += diagonal[i];
    }
    for (const Coupling& c : list) {
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, n);
      for (int k = 0; k < 5; ++k) {
        if (at(c.points, k) < 0) continue;
        j.block<3, 3>(0, 3 * at(c.points, k)) += at(c.coefficients, k) * Eigen::Matrix3d::Identity();
      }
      a += j.transpose() * (time_step * to_eigen(c.damping) + time_step * time_step * to_eigen(c.stiffness)) *
           j;
    }
    return a;
  }
  /// Zero at points that are not free.
  [[nodiscard]] std::vector<Vec3> random_free_vector(unsigned seed) const {
    auto x = random_vectors(free.size(), 1.0, seed);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (free[i] == 0) x[i] = {};
    }
    return x;
  }
  void restrict(Eigen::MatrixXd& a) const {
    for (std::size_t i = 0; i < free.size(); ++i) {
      if (free[i] != 0) continue;
      const auto row = 3 * static_cast<Eigen::Index>(i);
      a.middleRows<3>(row).setZero();
      a.middleCols<3>(row).setZero();
      a.block<3, 3>(row, row).setIdentity();
    }
  }

  parallel::Threads threads;
  Bodies bodies;
  Elements elements;
  std::vector<std::uint8_t> free;
  BlockMatrix matrix;
  CouplingSystem couplings;
  LinearSystem system;
  std::vector<double> diagonal;
  std::vector<double> factors;
  std::vector<Coupling> list;
};

inline SolveReport solve(System& s, ConjugateGradients& solver, std::span<const Vec3> b, std::vector<Vec3>& x,
                         const SolveGoal& goal) {
  auto padded_x = padded(x);
  const SolveReport report = solver.solve(s.threads, s.system, padded(b), padded_x, goal);
  x = unpadded(padded_x);
  return report;
}

/// Vectors by row, as solvers have them, and back.
inline std::vector<simd::Quad> quads_by_row(const System& s, std::span<const Vec3> values) {
  std::vector<simd::Quad> rows(s.matrix.row_count());
  for (std::size_t row = 0; row < s.matrix.point_of_row().size(); ++row) {
    if (s.matrix.point_of_row()[row] < 0) continue;
    const Vec3& v = at(values, s.matrix.point_of_row()[row]);
    rows[row] = {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z), 0.0F};
  }
  return rows;
}
inline std::vector<float> floats_by_row(const System& s, std::span<const Vec3> values) {
  const auto quads = quads_by_row(s, values);
  std::vector<float> rows(3 * quads.size());
  for (std::size_t row = 0; row < quads.size(); ++row) {
    float* place = rows.data() + simd::slice_values * (row / 16) + row % 16;
    place[0] = quads[row].x;
    place[16] = quads[row].y;
    place[32] = quads[row].z;
  }
  return rows;
}
inline std::vector<Vec3> by_point(const System& s, std::span<const float> rows) {
  std::vector<Vec3> values(s.free.size());
  for (std::size_t row = 0; row < s.matrix.point_of_row().size(); ++row) {
    const float* place = rows.data() + simd::slice_values * (row / 16) + row % 16;
    if (s.matrix.point_of_row()[row] < 0) continue;
    at(values, s.matrix.point_of_row()[row]) = {static_cast<double>(place[0]), static_cast<double>(place[16]),
                                                static_cast<double>(place[32])};
  }
  return values;
}

/// sqrt(sum of m x^2), or with 1/m.
inline double norm_by_mass(const System& s, const Eigen::VectorXd& x, double power) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.size(); ++i) sum += x[i] * x[i] * std::pow(at(s.diagonal, i / 3), power);
  return std::sqrt(sum);
}

}  // namespace palpate::fem::test

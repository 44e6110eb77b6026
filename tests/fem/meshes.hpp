#pragma once

#include <Eigen/Dense>
#include <array>
#include <functional>
#include <random>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

#include "fem/dynamics.hpp"
#include "fem/matrix.hpp"
#include "parallel/threads.hpp"
#include "support/meshes.hpp"

/// Small meshes and conversions for the tests of the dynamics, independent of the generators that ship.
namespace palpate::fem::test {

/// A box of cells from the origin to `size`, 5 tets a cell with alternating parity.
TetMesh box_mesh(const std::array<int, 3>& cells, const Vec3& size);
/// The same with the inner points moved by up to `fraction` of a cell.
TetMesh irregular_box_mesh(const std::array<int, 3>& cells, const Vec3& size, double fraction);
/// One tet with corners at the origin and at distance `size` along the axes.
TetMesh unit_tet_mesh(double size = 1.0);

using palpate::test::single_body;
/// One byte a point: 1 where the rest position fulfils `where`.
std::vector<std::uint8_t> select(const Bodies& bodies, const std::function<bool(const Vec3&)>& where);
/// Whether a point of a box from the origin to `size` is on its surface.
bool on_surface(const Vec3& p, const Vec3& size);

/// Positions at rest mapped one by one.
std::vector<Vec3> mapped(const Bodies& bodies, const std::function<Vec3(const Vec3&)>& map);
/// Positions at rest plus uniform noise of up to `amplitude` an axis.
std::vector<Vec3> noisy(const Bodies& bodies, double amplitude, unsigned seed);
std::vector<Vec3> random_vectors(std::size_t count, double amplitude, unsigned seed);
/// Uniform between `low` and 1.
std::vector<float> random_floats(std::size_t count, unsigned seed, float low = -1.0F);

Vec3 random_vector(std::mt19937_64& random, double amplitude);
/// A uniformly distributed rotation, made by Eigen.
Matrix3 random_rotation(std::mt19937_64& random);

Eigen::Matrix3d to_eigen(const Matrix3& a);
Eigen::Matrix3d to_eigen(const SymmetricMatrix3& a);
Eigen::Vector3d to_eigen(const Vec3& a);
Eigen::VectorXd to_eigen(std::span<const Vec3> a);
Matrix3 from_eigen(const Eigen::Matrix3d& a);

std::vector<simd::Padded3> padded(std::span<const Vec3> a);
std::vector<Vec3> unpadded(std::span<const simd::Padded3> a);

/// Largest length in an array.
double largest(std::span<const Vec3> values);
/// Largest distance between two arrays, point by point.
double largest_distance(std::span<const Vec3> a, std::span<const Vec3> b);
Vec3 total(std::span<const Vec3> values);

/// m/s^2.
inline constexpr Vec3 standard_gravity{0.0, 0.0, -9.81};

/// For what takes threads and needs none.
inline const parallel::Threads one_thread(1);

Vec3 momentum(const Dynamics& dynamics);

/// Elastic forces per point as of elements.update().
std::vector<Vec3> point_forces(const Elements& elements);

/// A Dynamics of one body; by default nothing is fixed and there is one thread.
struct Scene {
  Material material;
  std::vector<std::uint8_t> fixed;  ///< empty: nothing
  int threads = 1;
  [[nodiscard]] Dynamics dynamics(const Bodies& bodies) const;
};

/// Steps of huge length with the velocities cleared in between: Newton's method for the static equilibrium.
void settle(Dynamics& dynamics, std::span<const Vec3> forces, int steps, double tolerance = 1e-12,
            int max_iterations = 20000);

/// Elastic energy of all elements at these positions, J.
double total_energy(const Elements& elements, std::span<const Vec3> positions);
/// How many tets are inverted or flat at these positions.
int inverted_tets(const Bodies& bodies, std::span<const Vec3> positions);

/// Where a growing function is zero, by bisection.
double zero_of(const std::function<double(double)>& f, double low, double high);

/// Velocities of points that turn about their centre of mass like a rigid body with their angular momentum.
std::vector<Vec3> rotation_of(std::span<const double> masses, std::span<const Vec3> positions,
                              std::span<const Vec3> velocities);

/// All stiffness blocks of elements scattered into one matrix.
Eigen::MatrixXd dense_stiffness(const Elements& elements, std::size_t point_count);

}  // namespace palpate::fem::test

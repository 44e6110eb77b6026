#pragma once

#include <array>
#include <span>
#include <vector>

#include <palpate/types.hpp>

namespace palpate::fem {

/// Linear tets of one body for a scalar field: gradients of the shape functions.
class ScalarTets {
 public:
  /// \param points  (n_points x 3), not stored
  /// \param tets    of positive volume; indices minus `first_point` are indices into `points`
  ScalarTets(std::span<const Vec3> points, std::span<const Tet> tets, Index first_point);

  [[nodiscard]] std::size_t size() const { return tets_.size(); }
  [[nodiscard]] const Tet& corners(std::size_t tet) const { return tets_[tet]; }
  [[nodiscard]] Vec3 gradient(std::size_t tet, std::span<const double> field) const;
  /// The stiffness matrix of Laplace's equation times a field: integral of grad(field) . grad(N_i).
  void multiply(std::span<const double> field, std::vector<double>& result) const;
  [[nodiscard]] std::vector<double> diagonal(std::size_t n_points) const;

 private:
  std::vector<Tet> tets_;
  std::vector<std::array<Vec3, 4>> shape_gradients_;
  std::vector<double> volumes_;
};

/// Solves Laplace's equation with the field held at some points, and no flow through the rest of the surface.
/// Conjugate gradients with Jacobi's preconditioner until the residual is 1e-14 of the first, in one thread.
///
/// \param held   (n_points) 1: the field keeps its value; each connected piece needs such a point
/// \param field  (n_points) on entry the held values, and a guess at other points; on return the solution
void solve_laplace(const ScalarTets& tets, std::span<const std::uint8_t> held, std::vector<double>& field);

}  // namespace palpate::fem

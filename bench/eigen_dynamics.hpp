#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <span>
#include <vector>

#include <palpate/material.hpp>
#include <palpate/mesh.hpp>

/// Careful code that uses Eigen: the baseline of the dynamics.
namespace palpate::bench {

/// The system of an implicit Euler step from rest, (M + (h b + h^2) K') dv = h f, in compressed rows that are
/// refilled in place. Free points only.
class EigenDynamics {
 public:
  EigenDynamics(const Bodies& bodies, const Material& material, std::span<const std::uint8_t> free,
                std::span<const double> masses, double time_step);

  /// Rotations, forces and matrix at these positions.
  void update(std::span<const Vec3> positions, const Vec3& gravity);

  [[nodiscard]] const Eigen::SparseMatrix<double, Eigen::RowMajor>& matrix() const { return matrix_; }
  [[nodiscard]] const Eigen::VectorXd& right_side() const { return right_side_; }
  /// Number of a point among the free ones, -1 where it is not.
  [[nodiscard]] std::span<const int> place() const { return place_; }

 private:
  struct Element {
    Tet corners;
    Eigen::Matrix3d inverse_rest;
    double volume;
    std::array<int, 48> slots;  ///< of 4 x 4 x 3 rows of three values, -1: not free
  };
  [[nodiscard]] Eigen::Matrix3d deformation(const Element& element, std::span<const Vec3> positions) const;

  std::vector<Vec3> rest_;
  std::vector<int> place_;
  std::vector<double> masses_;
  double time_step_;
  double factor_;
  double mu_;
  double lambda_;
  std::vector<Element> elements_;
  std::vector<int> diagonal_slots_;
  Eigen::SparseMatrix<double, Eigen::RowMajor> matrix_;
  Eigen::VectorXd right_side_;
};

}  // namespace palpate::bench

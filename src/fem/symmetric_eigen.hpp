#pragma once

#include <array>

#include <palpate/types.hpp>

#include "fem/matrix.hpp"

namespace palpate::fem {

/// Eigenvalues of a symmetric matrix, largest first, and unit eigenvectors in that order.
struct SymmetricEigen {
  Vec3 values;
  std::array<Vec3, 3> vectors;
};

/// By cyclic Jacobi rotations (Golub & Van Loan, "Matrix Computations", 4th ed., section 8.5): eigenvalues up
/// to rounding of the largest, eigenvectors orthogonal up to rounding, also where eigenvalues are equal. The
/// largest component of each eigenvector is positive. NaN for a matrix that is not finite. The same bits on
/// every call and machine: no function of the C library but the square root.
[[nodiscard]] SymmetricEigen symmetric_eigen(const SymmetricMatrix3& a);
/// The matrix with each negative eigenvalue replaced by minus the part `kept` of it.
[[nodiscard]] SymmetricMatrix3 positive_part(const SymmetricEigen& eigen, double kept = 0.0);

}  // namespace palpate::fem

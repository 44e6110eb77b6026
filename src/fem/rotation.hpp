#pragma once

#include "fem/matrix.hpp"

namespace palpate::fem {

/// The rotation R nearest to a deformation gradient F: the R with det R = +1 that maximises tr(R^T F), which
/// is the orthogonal factor of F = R S where det F > 0.
///
/// Defined for every F: the result is a rotation (orthogonal to about 1e-15, det +1) also for inverted, flat
/// and collapsed elements. For F = 0, and if an entry is not finite, it is the identity. Accurate up to
/// rounding times |F| / (s2 + s3), the conditioning of the problem: s1 >= s2 >= |s3| are the singular values
/// of F, s3 < 0 if det F < 0. Exactly the identity for F = identity. Allocates nothing; the same bits on
/// every call.
///
/// Sources: the scaled Newton iteration of Higham, "Computing the polar decomposition - with applications",
/// SIAM J. Sci. Stat. Comput. 7 (1986), with scaling by Frobenius norms, for F with det F > 0.01
/// (largest entry scaled to 1); otherwise, or if that does not converge, the eigenvector of the largest
/// eigenvalue of the 4x4 matrix of Horn, "Closed-form solution of absolute orientation using unit
/// quaternions", J. Opt. Soc. Am. A 4 (1987), section 4, by cyclic Jacobi rotations. Unlike an SVD by F^T F
/// it does not square the condition number and has no special case for signs.
[[nodiscard]] Matrix3 nearest_rotation(const Matrix3& f);

}  // namespace palpate::fem

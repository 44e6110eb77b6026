#pragma once

#include <cstddef>

namespace palpate::fem {

/// Solves m x = b by Gaussian elimination with row pivoting; false if m is singular. O(n^3).
/// \param m       (n rows of `stride`), overwritten
/// \param x  (n)  b on entry, the solution on return
bool solve_by_elimination(double* m, std::size_t stride, std::size_t n, double* x);

}  // namespace palpate::fem

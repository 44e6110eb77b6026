// The kernels of gauss_seidel.cpp in plain C++. Targets without vectors run these.
#include "simd/gauss_seidel.hpp"

namespace palpate::simd::scalar {
namespace {

using Matrix = std::array<float, 9>;

std::size_t place_of(std::size_t row) {
  return slice_values * (row / slice_rows) + row % slice_rows;
}

float cofactor(const Matrix& m, std::size_t i, std::size_t j) {
  const std::size_t a = (i + 1) % 3;
  const std::size_t b = (i + 2) % 3;
  const std::size_t c = (j + 1) % 3;
  const std::size_t e = (j + 2) % 3;
  return m[3 * a + c] * m[3 * b + e] - m[3 * a + e] * m[3 * b + c];
}

float determinant(const Matrix& m) {
  return m[0] * cofactor(m, 0, 0) + m[1] * cofactor(m, 0, 1) + m[2] * cofactor(m, 0, 2);
}

Matrix rotation_of(const SmootherRows& rows, std::size_t row) {
  Matrix m{};
  for (std::size_t k = 0; k < 9; ++k)
    m[k] = rows.rotations[slot_values * (row / slice_rows) + slice_rows * k + row % slice_rows];
  return m;
}

Quad without_couplings(const CouplingRows& couplings, std::size_t row, Quad y) {
  for (std::int32_t e = couplings.begin[row]; e < couplings.begin[row + 1]; ++e) {
    const CouplingEntry& entry = couplings.entries[e];
    const Quad& product = couplings.products[entry.coupling];
    const float c = entry.coefficient;
    y = {y.x - c * product.x, y.y - c * product.y, y.z - c * product.z, 0.0F};
  }
  return y;
}

Quad residual_of(const SmootherRows& all, const float* r, const Quad* z, std::size_t row) {
  const SlicedRows& rows = all.rows;
  const std::size_t slice = row / slice_rows;
  const std::size_t lane = row % slice_rows;
  const float* from = r + place_of(row);
  const Quad& own = z[row];
  const float m = rows.masses[row];
  Quad y{from[0] - m * own.x, from[slice_rows] - m * own.y, from[2 * slice_rows] - m * own.z, 0.0F};
  for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
    const Quad& other = z[rows.columns[slice_rows * slot + lane]];
    const float* k = rows.values + slot_values * slot + lane;
    const Quad u{own.x - other.x, own.y - other.y, own.z - other.z, 0.0F};
    const auto entry = [&](std::size_t i) {
      return k[slice_rows * i] * u.x + k[slice_rows * (i + 1)] * u.y + k[slice_rows * (i + 2)] * u.z;
    };
    y = {y.x + entry(0), y.y + entry(3), y.z + entry(6), 0.0F};
  }
  return without_couplings(all.couplings, row, y);
}

/// y - K z with the columns that belong to earlier colours or, if `later`, to the others.
Quad without_columns(const SlicedRows& rows, const Quad* z, std::size_t row, bool later, Quad y) {
  const std::size_t slice = row / slice_rows;
  const std::size_t lane = row % slice_rows;
  for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
    const std::uint32_t column = rows.columns[slice_rows * slot + lane];
    if ((column >= rows.halves[slice].color_begin) != later) continue;
    const Quad& u = z[column];
    const float* k = rows.values + slot_values * slot + lane;
    const auto entry = [&](std::size_t i) {
      return k[slice_rows * i] * u.x + k[slice_rows * (i + 1)] * u.y + k[slice_rows * (i + 2)] * u.z;
    };
    y = {y.x - entry(0), y.y - entry(3), y.z - entry(6), 0.0F};
  }
  return y;
}

/// start + A v with the symmetric matrix of a row.
Quad add_symmetric(const float* matrices, std::size_t row, const Quad& v, const Quad& start) {
  const float* matrix = matrices + slice_symmetric * (row / slice_rows) + row % slice_rows;
  const auto entry = [&](std::size_t k) { return matrix[slice_rows * k]; };
  return {start.x + entry(0) * v.x + entry(3) * v.y + entry(4) * v.z,
          start.y + entry(3) * v.x + entry(1) * v.y + entry(5) * v.z,
          start.z + entry(4) * v.x + entry(5) * v.y + entry(2) * v.z, 0.0F};
}

bool has_couplings(const CouplingRows& couplings, std::size_t slice) {
  return couplings.begin[slice_rows * slice] != couplings.begin[slice_rows * (slice + 1)];
}

}  // namespace

void relax_slices(const SmootherRows& rows, const float* r, Quad* z, const std::uint32_t* slices,
                  std::size_t count) {
  for (std::size_t s = 0; s < count; ++s) {
    std::array<Quad, slice_rows> y;
    for (std::size_t lane = 0; lane < slice_rows; ++lane)
      y[lane] = residual_of(rows, r, z, slice_rows * slices[s] + lane);
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      const std::size_t row = slice_rows * slices[s] + lane;
      z[row] = add_symmetric(rows.inverses, row, y[lane], z[row]);
    }
  }
}

void relax_from_zero(const SmootherRows& rows, const float* r, Quad* z, float* rest,
                     const std::uint32_t* slices, std::size_t count) {
  for (std::size_t s = 0; s < count; ++s) {
    for (std::size_t row = slice_rows * slices[s]; row < slice_rows * (slices[s] + 1); ++row) {
      const std::size_t place = place_of(row);
      const Quad right{r[place], r[place + slice_rows], r[place + 2 * slice_rows], 0.0F};
      const Quad y = without_columns(rows.rows, z, row, false, right);
      if (has_couplings(rows.couplings, slices[s])) {
        rest[place] = y.x;
        rest[place + slice_rows] = y.y;
        rest[place + 2 * slice_rows] = y.z;
      }
      z[row] = add_symmetric(rows.inverses, row, without_couplings(rows.couplings, row, y), {});
    }
  }
}

void rotated_residual(const SmootherRows& rows, const float* rest, const Quad* z, Quad* t, std::size_t begin,
                      std::size_t end) {
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    Quad y;
    if (has_couplings(rows.couplings, row / slice_rows)) {
      const std::size_t place = place_of(row);
      y = add_symmetric(rows.diagonals, row, {-z[row].x, -z[row].y, -z[row].z, 0.0F},
                        {rest[place], rest[place + slice_rows], rest[place + 2 * slice_rows], 0.0F});
    }
    y = without_couplings(rows.couplings, row, without_columns(rows.rows, z, row, true, y));
    const Matrix m = rotation_of(rows, row);
    t[row] = {m[0] * y.x + m[3] * y.y + m[6] * y.z, m[1] * y.x + m[4] * y.y + m[7] * y.z,
              m[2] * y.x + m[5] * y.y + m[8] * y.z, 0.0F};
  }
}

void add_rotated(const SmootherRows& rows, const Quad* u, Quad* z, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    const Matrix m = rotation_of(rows, row);
    const Quad& v = u[row];
    Quad& own = z[row];
    own = {own.x + m[0] * v.x + m[1] * v.y + m[2] * v.z, own.y + m[3] * v.x + m[4] * v.y + m[5] * v.z,
           own.z + m[6] * v.x + m[7] * v.y + m[8] * v.z, 0.0F};
  }
}

double store_slices(const Quad* z, const float* r, float* values, std::size_t begin, std::size_t end) {
  double inner = 0.0;
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    const std::size_t place = place_of(row);
    values[place] = z[row].x;
    values[place + slice_rows] = z[row].y;
    values[place + 2 * slice_rows] = z[row].z;
    inner += static_cast<double>(r[place] * z[row].x + r[place + slice_rows] * z[row].y +
                                 r[place + 2 * slice_rows] * z[row].z);
  }
  return inner;
}

void listed_products(const CouplingTerm* couplings, const Quad* x, Quad* products, const std::uint32_t* list,
                     std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    scalar::coupling_products(couplings, x, products, list[i], list[i] + 1);
}

void find_rotations(const RotationRows& rows, const Quad* positions, float* rotations, std::size_t begin,
                    std::size_t end) {
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    const std::size_t slice = row / slice_rows;
    const std::size_t lane = row % slice_rows;
    const Quad& own = positions[row];
    Matrix f{};
    for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
      const Quad& other = positions[rows.columns[slice_rows * slot + lane]];
      const std::array u{other.x - own.x, other.y - own.y, other.z - own.z};
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t r = 0; r < 3; ++r)
          f[3 * r + k] += u[r] * rows.edges[slice_values * slot + slice_rows * k + lane];
      }
    }
    const float start = determinant(f);
    if (!(start > 0.1F && start < 10.0F)) f = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int step = 0; step < 8; ++step) {
      const float inverse = 0.5F / determinant(f);
      Matrix next{};
      for (std::size_t k = 0; k < 9; ++k) next[k] = inverse * cofactor(f, k / 3, k % 3) + 0.5F * f[k];
      f = next;
    }
    for (std::size_t k = 0; k < 9; ++k) rotations[slot_values * slice + slice_rows * k + lane] = f[k];
  }
}

}  // namespace palpate::simd::scalar

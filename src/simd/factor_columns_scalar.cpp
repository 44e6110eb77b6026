// The twins of the kernels of factor_columns.cpp in plain C++, also what runs where there are no vectors.
#include <array>

#include "simd/factor_columns.hpp"

namespace palpate::simd::scalar {
namespace {

using Matrix = std::array<float, 9>;

float cofactor(const Matrix& m, std::size_t i, std::size_t j) {
  const std::size_t a = (i + 1) % 3;
  const std::size_t b = (i + 2) % 3;
  const std::size_t c = (j + 1) % 3;
  const std::size_t d = (j + 2) % 3;
  return m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c];
}

float determinant(const Matrix& m) {
  return m[0] * cofactor(m, 0, 0) + m[1] * cofactor(m, 0, 1) + m[2] * cofactor(m, 0, 2);
}

std::size_t place_of(std::size_t row) {
  return slice_values * (row / slice_rows) + row % slice_rows;
}

Matrix rotation_of(const TurnedRows& rows, std::size_t row) {
  const float* from = rows.rotations + slot_values * (row / slice_rows) + row % slice_rows;
  Matrix m{};
  for (std::size_t k = 0; k < 9; ++k) m[k] = from[slice_rows * k];
  return m;
}

/// block x, of a block column by column; or its transpose times x.
Quad product(const float* m, const Quad& x) {
  return {m[0] * x.x + m[3] * x.y + m[6] * x.z, m[1] * x.x + m[4] * x.y + m[7] * x.z,
          m[2] * x.x + m[5] * x.y + m[8] * x.z, 0.0F};
}
Quad product_back(const float* m, const Quad& x) {
  return {m[0] * x.x + m[1] * x.y + m[2] * x.z, m[3] * x.x + m[4] * x.y + m[5] * x.z,
          m[6] * x.x + m[7] * x.y + m[8] * x.z, 0.0F};
}
void subtract(Quad& a, const Quad& b) {
  a = {a.x - b.x, a.y - b.y, a.z - b.z, 0.0F};
}

}  // namespace

void solve_columns(const FactorColumns& columns, Quad* b, ColumnRange first, ColumnRange second) {
  for (const ColumnRange range : {first, second}) {
    for (std::size_t j = range.begin; j < range.end; ++j) {
      b[j] = product(columns.inverses + 9 * j, b[j]);
      for (std::size_t k = columns.begin[j]; k < columns.begin[j + 1]; ++k)
        subtract(b[columns.rows[k]], product(columns.blocks + 9 * k, b[j]));
    }
    for (std::size_t j = range.end; j-- > range.begin;) {
      Quad sum;
      for (std::size_t k = columns.begin[j]; k < columns.begin[j + 1]; ++k) {
        const Quad part = product_back(columns.blocks + 9 * k, b[columns.rows[k]]);
        sum = {sum.x + part.x, sum.y + part.y, sum.z + part.z, 0.0F};
      }
      subtract(b[j], sum);
      b[j] = product_back(columns.inverses + 9 * j, b[j]);
    }
  }
}

void find_rotations(const TurnedRows& rows, const Quad* positions, std::size_t begin, std::size_t end) {
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
    for (int step = 0; step < 3; ++step) {
      const float inverse = 0.5F / determinant(f);
      Matrix next{};
      for (std::size_t k = 0; k < 9; ++k) next[k] = inverse * cofactor(f, k / 3, k % 3) + 0.5F * f[k];
      f = next;
    }
    for (std::size_t k = 0; k < 9; ++k) rows.rotations[slot_values * slice + slice_rows * k + lane] = f[k];
  }
}

void turn_back(const TurnedRows& rows, const float* r, Quad* quads, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    const Matrix m = rotation_of(rows, row);
    const float* from = r + place_of(row);
    const float t = rows.taken[row];
    quads[rows.places[row]] = product(m.data(), {t * from[0], t * from[slice_rows], t * from[2 * slice_rows],
                                                 0.0F});  // by rows: transposed
  }
}

double turn_forth(const TurnedRows& rows, const float* r, const Quad* quads, float* z, std::size_t begin,
                  std::size_t end) {
  double inner = 0.0;
  for (std::size_t row = begin * slice_rows; row < end * slice_rows; ++row) {
    const std::size_t place = place_of(row);
    if (rows.taken[row] > 0.0F) {
      const Quad turned = product_back(rotation_of(rows, row).data(), quads[rows.places[row]]);
      z[place] = turned.x;
      z[place + slice_rows] = turned.y;
      z[place + 2 * slice_rows] = turned.z;
    }
    for (std::size_t k = 0; k < 3; ++k)
      inner += static_cast<double>(r[place + slice_rows * k] * z[place + slice_rows * k]);
  }
  return inner;
}

}  // namespace palpate::simd::scalar

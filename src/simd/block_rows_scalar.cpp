// The twins of the kernels of block_rows.cpp in plain C++, also what runs where vectors have fewer than four
// doubles.
#include <algorithm>

#include "simd/block_rows.hpp"

namespace palpate::simd::scalar {
namespace {

double dot(const Padded3& a, const Padded3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// a + s b
Padded3 plus(const Padded3& a, double s, const Padded3& b) {
  return {a.x + s * b.x, a.y + s * b.y, a.z + s * b.z, 0.0};
}

/// Product of a matrix of three columns of four with a row.
Padded3 product(const double* m, const Padded3& x) {
  return {m[0] * x.x + m[4] * x.y + m[8] * x.z, m[1] * x.x + m[5] * x.y + m[9] * x.z,
          m[2] * x.x + m[6] * x.y + m[10] * x.z, 0.0};
}

/// block += r X + X^T + tr(X) I with X = a b^T, by columns of four in steps of eight.
void add_term(const Padded3& a, const Padded3& b, double ratio, double* block) {
  const std::array<double, 3> x{a.x, a.y, a.z};
  const std::array<double, 3> y{b.x, b.y, b.z};
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row)
      block[8 * column + row] += ratio * (x[row] * y[column]) + x[column] * y[row];
    block[9 * column] += dot(a, b);
  }
}

}  // namespace

void assemble_rows(const AssemblyRows& rows, double* values, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    const std::size_t first = rows.pair_begin[row];
    const std::size_t last = rows.pair_begin[row + 1];
    if (first == last) continue;
    double* own = values + 24 * first;
    std::fill(own, values + 24 * last, 0.0);
    for (std::int32_t i = rows.incidence_begin[row]; i < rows.incidence_begin[row + 1]; ++i) {
      const Incidence& incidence = rows.incidences[i];
      const Padded3* other = rows.gradients + (incidence.own & ~std::uint32_t{3});
      for (std::size_t j = 0; j < 4; ++j) {
        add_term(rows.gradients[incidence.own], other[(incidence.own + j) & 3],
                 rows.ratios[incidence.own / 4], own + incidence.places[j]);
      }
    }
    const std::size_t place = rows.diagonal_block[row] - 2 * first;
    for (std::size_t k = 0; k < 3; ++k) own[24 * (place / 2) + 4 * (place % 2) + 9 * k] += rows.diagonal[row];
  }
}

void coupling_products(const CouplingTerm* couplings, const Padded3* x, Padded3* products, std::size_t begin,
                       std::size_t end) {
  for (std::size_t c = begin; c < end; ++c) {
    const CouplingTerm& coupling = couplings[c];
    Padded3 sum;
    for (std::size_t k = 0; k < 5; ++k) {
      sum = plus(sum, coupling.coefficients[k], x[static_cast<std::size_t>(coupling.points[k])]);
    }
    products[c] = product(coupling.weights.data(), sum);
  }
}

double multiply_rows(const BlockRows& blocks, const CouplingRows& couplings, const Padded3* x, Padded3* y,
                     std::size_t begin, std::size_t end) {
  double inner = 0.0;
  for (std::size_t row = begin; row < end; ++row) {
    Padded3 sum;
    const std::size_t last = std::size_t{2} * blocks.pair_begin[row + 1];
    for (std::size_t block = std::size_t{2} * blocks.pair_begin[row]; block < last; ++block) {
      const Padded3& other = x[blocks.columns[block]];
      const double* m = blocks.values + 24 * (block / 2) + 4 * (block % 2);
      const auto entry = [&](std::size_t k) {
        return m[k] * other.x + m[k + 8] * other.y + m[k + 16] * other.z;
      };
      sum = {sum.x + entry(0), sum.y + entry(1), sum.z + entry(2), 0.0};
    }
    for (std::int32_t e = couplings.begin[row]; e < couplings.begin[row + 1]; ++e) {
      sum = plus(sum, couplings.entries[e].coefficient, couplings.products[couplings.entries[e].coupling]);
    }
    y[row] = sum;
    inner += dot(x[row], sum);
  }
  return inner;
}

VectorSums advance_rows(const GradientVectors& v, double step, std::size_t begin, std::size_t end) {
  VectorSums sums;
  for (std::size_t row = begin; row < end; ++row) {
    v.solution[row] = plus(v.solution[row], step, v.direction[row]);
    v.residual[row] = plus(v.residual[row], -step, v.product[row]);
    v.preconditioned[row] = product(v.inverse_diagonal + 12 * row, v.residual[row]);
    const double square = dot(v.residual[row], v.residual[row]);
    sums.residual += square;
    sums.by_mass += square * v.inverse_masses[row];
    sums.solution += dot(v.solution[row], v.solution[row]) * v.masses[row];
    sums.preconditioned += dot(v.residual[row], v.preconditioned[row]);
  }
  return sums;
}

void turn_rows(const GradientVectors& v, double turn, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    v.direction[row] = plus(v.preconditioned[row], turn, v.direction[row]);
  }
}

}  // namespace palpate::simd::scalar

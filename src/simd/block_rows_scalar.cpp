// The twins of the kernels of block_rows.cpp in plain C++, also what runs where vectors have fewer than four
// doubles.
#include "simd/block_rows.hpp"

namespace palpate::simd::scalar {
namespace {

using Three = std::array<double, 3>;
/// Column by column.
using Block = std::array<Three, 3>;

Three values_of(const Padded3& row) {
  return {row.x, row.y, row.z};
}

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

/// Sum of r X + X^T + tr(X) I over the terms of a block.
Block block_of(const BlockTerms& terms, std::size_t block) {
  Block x{};
  Block y{};
  for (std::uint32_t t = terms.term_begin[block]; t < terms.term_begin[block + 1]; ++t) {
    const std::uint32_t term = terms.terms[t];
    const Three a = values_of(terms.gradients[term >> 2]);
    const Three b = values_of(terms.gradients[(term >> 4 << 2) | (term & 3)]);
    const double ratio = terms.ratios[term >> 4];
    for (std::size_t column = 0; column < 3; ++column) {
      for (std::size_t row = 0; row < 3; ++row) {
        const double one = a[row] * b[column];
        x[column][row] += one;
        y[column][row] += ratio * one;
      }
    }
  }
  const double trace = x[0][0] + x[1][1] + x[2][2];
  for (std::size_t column = 0; column < 3; ++column) {
    for (std::size_t row = 0; row < 3; ++row) y[column][row] += x[row][column];
    y[column][column] += trace;
  }
  return y;
}

}  // namespace

void assemble_rows(const BlockTerms& terms, BlockValue* values, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    const std::size_t last = std::size_t{2} * terms.pair_begin[row + 1];
    for (std::size_t block = std::size_t{2} * terms.pair_begin[row]; block < last; ++block) {
      const Block whole = block_of(terms, block);
      const double diagonal = block == terms.diagonal_block[row] ? terms.diagonal[row] : 0.0;
      BlockValue* out = values + 24 * (block / 2) + 4 * (block % 2);
      for (std::size_t column = 0; column < 3; ++column) {
        for (std::size_t k = 0; k < 3; ++k) {
          out[8 * column + k] = static_cast<BlockValue>(whole[column][k] + (column == k ? diagonal : 0.0));
        }
        out[8 * column + 3] = 0;
      }
    }
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
      const BlockValue* m = blocks.values + 24 * (block / 2) + 4 * (block % 2);
      const auto entry = [&](std::size_t k) {
        return double{m[k]} * other.x + double{m[k + 8]} * other.y + double{m[k + 16]} * other.z;
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
    sums.residual += dot(v.residual[row], v.residual[row]) * v.inverse_masses[row];
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

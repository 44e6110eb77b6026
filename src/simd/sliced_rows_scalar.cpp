// The kernels of sliced_rows.cpp in plain C++. Targets without vectors run these.
#include <algorithm>
#include <cmath>

#include "simd/sliced_rows.hpp"

namespace palpate::simd::scalar {
namespace {

using Block = std::array<float, 9>;

/// Sum of r X + X^T + tr(X) I of a row's terms.
Block block_of(const SlicedAssembly& rows, std::size_t first, std::size_t last, std::size_t lane) {
  Block block{};
  for (std::size_t t = first; t < last; ++t) {
    const std::uint32_t term = rows.terms[slice_rows * t + lane];
    const Quad& a = rows.gradients[term >> 2U];
    const Quad& b = rows.gradients[(term >> 4U << 2U) | (term & 3U)];
    const std::array<float, 3> x{a.x, a.y, a.z};
    const std::array<float, 3> y{b.x, b.y, b.z};
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) block[3 * i + j] += a.w * (x[i] * y[j]) + x[j] * y[i];
      block[4 * i] += x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
    }
  }
  return block;
}

void add_couplings(const CouplingRows& couplings, std::size_t slice, float* y) {
  for (std::size_t row = 0; row < slice_rows; ++row) {
    const std::int32_t* begin = couplings.begin + slice_rows * slice + row;
    for (std::int32_t e = begin[0]; e < begin[1]; ++e) {
      const CouplingEntry& entry = couplings.entries[e];
      const Quad& product = couplings.products[entry.coupling];
      y[row] += entry.coefficient * product.x;
      y[slice_rows + row] += entry.coefficient * product.y;
      y[2 * slice_rows + row] += entry.coefficient * product.z;
    }
  }
}

}  // namespace

void assemble_slices(const SlicedAssembly& rows, float* values, float* diagonals, std::size_t begin,
                     std::size_t end) {
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      Block sum{};
      for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
        const Block block = block_of(rows, rows.term_begin[slot], rows.term_begin[slot + 1], lane);
        for (std::size_t k = 0; k < 9; ++k) {
          values[slot_values * slot + slice_rows * k + lane] = block[k];
          sum[k] += block[k];
        }
      }
      const float mass = rows.masses[slice_rows * slice + lane];
      const std::array symmetric{mass - sum[0], mass - sum[4], mass - sum[8], -sum[1], -sum[2], -sum[5]};
      for (std::size_t k = 0; k < 6; ++k)
        diagonals[slice_symmetric * slice + slice_rows * k + lane] = symmetric[k];
    }
  }
}

void assemble_tangent_slices(const TangentAssembly& rows, float* values, std::size_t begin, std::size_t end) {
  for (std::size_t slot = rows.slot_begin[begin]; slot < rows.slot_begin[end]; ++slot) {
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      Block sum{};
      for (std::size_t t = rows.term_begin[slot]; t < rows.term_begin[slot + 1]; ++t) {
        const std::uint32_t term = rows.terms[slice_rows * t + lane];
        const float* block = rows.blocks + (term >> 1U);
        for (std::size_t k = 0; k < 9; ++k) sum[k] += block[term % 2 == 0 ? k : 3 * (k % 3) + k / 3];
      }
      for (std::size_t k = 0; k < 9; ++k) values[slot_values * slot + slice_rows * k + lane] = sum[k];
    }
  }
}

void sum_diagonals(const std::uint32_t* slot_begin, const float* values, const float* masses,
                   float* diagonals, std::size_t begin, std::size_t end) {
  constexpr std::array<std::size_t, 6> upper{0, 4, 8, 1, 2, 5};
  for (std::size_t slice = begin; slice < end; ++slice) {
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      std::array<float, 6> sums{};
      for (std::size_t slot = slot_begin[slice]; slot < slot_begin[slice + 1]; ++slot) {
        for (std::size_t k = 0; k < 6; ++k)
          sums[k] += values[slot_values * slot + slice_rows * upper[k] + lane];
      }
      const float mass = masses[slice_rows * slice + lane];
      for (std::size_t k = 0; k < 6; ++k)
        diagonals[slice_symmetric * slice + slice_rows * k + lane] = k < 3 ? mass - sums[k] : -sums[k];
    }
  }
}

void coupling_products(const CouplingTerm* couplings, const Quad* x, Quad* products, std::size_t begin,
                       std::size_t end) {
  for (std::size_t c = begin; c < end; ++c) {
    const CouplingTerm& coupling = couplings[c];
    Quad sum;
    for (std::size_t k = 0; k < 5; ++k) {
      const Quad& row = x[coupling.rows[k]];
      const float s = coupling.coefficients[k];
      sum = {sum.x + s * row.x, sum.y + s * row.y, sum.z + s * row.z, 0.0F};
    }
    const auto& w = coupling.weights;
    products[c] = {w[0] * sum.x + w[4] * sum.y + w[8] * sum.z, w[1] * sum.x + w[5] * sum.y + w[9] * sum.z,
                   w[2] * sum.x + w[6] * sum.y + w[10] * sum.z, 0.0F};
  }
}

double multiply_slices(const SlicedRows& rows, const CouplingRows& couplings, const Quad* x, float* y,
                       std::size_t begin, std::size_t end) {
  double inner = 0.0;
  for (std::size_t slice = begin; slice < end; ++slice) {
    float* place = y + slice_values * slice;
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      const std::size_t row = slice_rows * slice + lane;
      const Quad& own = x[row];
      const float m = rows.masses[row];
      Quad sum{m * own.x, m * own.y, m * own.z, 0.0F};
      for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
        const Quad& other = x[rows.columns[slice_rows * slot + lane]];
        const float* k = rows.values + slot_values * slot + lane;
        const Quad u{other.x - own.x, other.y - own.y, other.z - own.z, 0.0F};
        const auto entry = [&](std::size_t i) {
          return k[slice_rows * i] * u.x + k[slice_rows * (i + 1)] * u.y + k[slice_rows * (i + 2)] * u.z;
        };
        sum = {sum.x + entry(0), sum.y + entry(3), sum.z + entry(6), 0.0F};
      }
      place[lane] = sum.x;
      place[slice_rows + lane] = sum.y;
      place[2 * slice_rows + lane] = sum.z;
    }
    add_couplings(couplings, slice, place);
    for (std::size_t lane = 0; lane < slice_rows; ++lane) {
      const Quad& own = x[slice_rows * slice + lane];
      inner += static_cast<double>(own.x * place[lane] + own.y * place[slice_rows + lane] +
                                   own.z * place[2 * slice_rows + lane]);
    }
  }
  return inner;
}

void invert_slices(const float* blocks, float* inverses, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; ++i) {
    const std::size_t place = slice_symmetric * (i / slice_rows) + i % slice_rows;
    std::array<float, 6> a{};
    for (std::size_t k = 0; k < 6; ++k) a[k] = blocks[place + slice_rows * k];
    std::array<float, 6> result{};
    const float g00 = 1.0F / std::sqrt(a[0]);
    const float l10 = a[3] * g00;
    const float l20 = a[4] * g00;
    const float pivot1 = a[1] - l10 * l10;
    const float g11 = 1.0F / std::sqrt(pivot1);
    const float l21 = (a[5] - l20 * l10) * g11;
    const float pivot2 = a[2] - l20 * l20 - l21 * l21;
    const float g22 = 1.0F / std::sqrt(pivot2);
    if (pivot1 > 0.0F && pivot2 > 0.0F) {
      const float g10 = -l10 * g00 * g11;
      const float g21 = -l21 * g11 * g22;
      const float g20 = -(l20 * g00 + l21 * g10) * g22;
      result = {g00 * g00 + g10 * g10 + g20 * g20,
                g11 * g11 + g21 * g21,
                g22 * g22,
                g10 * g11 + g20 * g21,
                g20 * g22,
                g21 * g22};
    } else {
      result = {1.0F / a[0], 1.0F / a[1], 1.0F / a[2], 0.0F, 0.0F, 0.0F};
    }
    if (!(a[0] > 0.0F)) result = {};
    for (std::size_t k = 0; k < 6; ++k) inverses[place + slice_rows * k] = result[k];
  }
}

VectorSums advance_slices(const GradientVectors& v, float step, std::size_t begin, std::size_t end) {
  VectorSums sums;
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; ++i) {
    const std::size_t slice = i / slice_rows;
    const std::size_t place = slice_values * slice + i % slice_rows;
    const std::array<float, 3> p{v.direction[i].x, v.direction[i].y, v.direction[i].z};
    std::array<float, 3> r{};
    float r_square = 0.0F;
    float x_square = 0.0F;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t at = place + slice_rows * k;
      v.solution[at] += step * p[k];
      v.residual[at] -= step * v.product[at];
      r[k] = v.residual[at];
      const float whole = v.guess[at] + v.solution[at];
      r_square += r[k] * r[k];
      x_square += whole * whole;
    }
    const float* d = v.inverse_diagonal + slice_symmetric * slice + i % slice_rows;
    const auto entry = [&](std::size_t k) { return d[slice_rows * k]; };
    const std::array z{entry(0) * r[0] + entry(3) * r[1] + entry(4) * r[2],
                       entry(3) * r[0] + entry(1) * r[1] + entry(5) * r[2],
                       entry(4) * r[0] + entry(5) * r[1] + entry(2) * r[2]};
    for (std::size_t k = 0; k < 3; ++k) v.preconditioned[place + slice_rows * k] = z[k];
    sums.residual += static_cast<double>(r_square);
    sums.by_mass += static_cast<double>(r_square * v.inverse_masses[i]);
    sums.preconditioned += static_cast<double>(r[0] * z[0] + r[1] * z[1] + r[2] * z[2]);
    sums.solution += static_cast<double>(x_square * v.masses[i]);
  }
  return sums;
}

void update_directions(const GradientVectors& v, float beta, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; ++i) {
    const float* z = v.preconditioned + slice_values * (i / slice_rows) + i % slice_rows;
    Quad& p = v.direction[i];
    p = {z[0] + beta * p.x, z[slice_rows] + beta * p.y, z[2 * slice_rows] + beta * p.z, 0.0F};
  }
}

}  // namespace palpate::simd::scalar

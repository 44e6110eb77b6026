// The kernels of padded_rows.cpp in plain C++. Targets without vectors run these.
#include "simd/padded_rows.hpp"

namespace palpate::simd::scalar {
namespace {

/// s += sign block x. The block has `columns` columns of `stride` values.
void add_block(float* s, const float* block, const float* x, std::size_t columns, std::size_t stride,
               float sign) {
  for (std::size_t k = 0; k < columns; ++k) {
    for (std::size_t i = 0; i < stride; ++i) s[i] += sign * block[stride * k + i] * x[k];
  }
}

void subtract_columns(Six& s, const SixMatrix& a, const Six* x, std::size_t row, std::size_t low,
                      std::size_t high) {
  for (const PaddedRows* part : {&a.first, &a.second}) {
    for (std::size_t k = part->begin[row]; k < part->begin[row + 1]; ++k) {
      const std::size_t column = part->columns[k];
      if (column >= low && column < high)
        add_block(s.values.data(), part->blocks + six_by_six * k, x[column].values.data(), 6, 8, -1.0F);
    }
  }
}

void relax_row(const SixMatrix& a, const Six& s, Six* x, std::size_t row) {
  x[row] = {};
  add_block(x[row].values.data(), a.inverses + six_by_six * row, s.values.data(), 6, 8, 1.0F);
}

}  // namespace

void multiply_six_by_three(const PaddedRows& a, const Quad* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    y[row] = {};
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k) {
      const Quad& v = x[a.columns[k]];
      const std::array values{v.x, v.y, v.z};
      add_block(y[row].values.data(), a.blocks + six_by_three * k, values.data(), 3, 8, 1.0F);
    }
  }
}

void multiply_three_by_six(const PaddedRows& a, const Six* x, Quad* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    std::array<float, 4> sum{};
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k)
      add_block(sum.data(), a.blocks + three_by_six * k, x[a.columns[k]].values.data(), 6, 4, 1.0F);
    y[row] = {sum[0], sum[1], sum[2], sum[3]};
  }
}

void multiply_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) y[row] = {};
  scalar::add_six(a, x, y, begin, end);
}

void add_six(const PaddedRows& a, const Six* x, Six* y, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    for (std::size_t k = a.begin[row]; k < a.begin[row + 1]; ++k)
      add_block(y[row].values.data(), a.blocks + six_by_six * k, x[a.columns[k]].values.data(), 6, 8, 1.0F);
  }
}

void relax_forward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    Six s = b[row];
    subtract_columns(s, a, x, row, begin, row);
    relax_row(a, s, x, row);
  }
}

void relax_forward_from(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    Six s = b[row];
    subtract_columns(s, a, x, row, begin, end);
    relax_row(a, s, x, row);
  }
}

void relax_backward(const SixMatrix& a, const Six* b, Six* x, std::size_t begin, std::size_t end) {
  for (std::size_t row = end; row-- > begin;) {
    Six s = b[row];
    subtract_columns(s, a, x, row, begin, end);
    relax_row(a, s, x, row);
  }
}

void residual_above(const SixMatrix& a, const Six* x, Six* r, std::size_t begin, std::size_t end) {
  for (std::size_t row = begin; row < end; ++row) {
    r[row] = {};
    subtract_columns(r[row], a, x, row, row, ~std::size_t{0});
  }
}

}  // namespace palpate::simd::scalar

#include "simd/block_rows.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/block_rows.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

using Four = hn::FixedTag<double, 4>;
using Row = hn::Vec<Four>;
using Wide = hn::CappedTag<double, 8>;

HWY_INLINE Row load(const Padded3& row) {
  return hn::Load(Four(), &row.x);
}
HWY_INLINE void store(Row value, Padded3& row) {
  hn::Store(value, Four(), &row.x);
}
template <class D>
HWY_INLINE hn::Vec<D> load_values(D d, const double* values) {
  return hn::Load(d, values);
}
template <class D>
HWY_INLINE hn::Vec<D> load_values(D d, const float* values) {
  return hn::PromoteTo(d, hn::Load(hn::Rebind<float, D>(), values));
}
HWY_INLINE void store_values(Row value, double* values) {
  hn::Store(value, Four(), values);
}
HWY_INLINE void store_values(Row value, float* values) {
  const hn::Rebind<float, Four> d;
  hn::Store(hn::DemoteTo(d, value), d, values);
}

/// Three columns of a block.
struct Block {
  Row c0, c1, c2;
};

HWY_INLINE Block zero_block() {
  const Row zero = hn::Zero(Four());
  return {zero, zero, zero};
}

/// X += a b^T
HWY_INLINE void add_outer(Row a, const Padded3& b, Block& x) {
  const Four d;
  x.c0 = hn::MulAdd(a, hn::Set(d, b.x), x.c0);
  x.c1 = hn::MulAdd(a, hn::Set(d, b.y), x.c1);
  x.c2 = hn::MulAdd(a, hn::Set(d, b.z), x.c2);
}

HWY_INLINE Block transposed(const Block& x) {
  const Four d;
  const Row zero = hn::Zero(d);
  const Row xz01 = hn::InterleaveLower(d, x.c0, x.c1);
  const Row yw01 = hn::InterleaveUpper(d, x.c0, x.c1);
  const Row xz2 = hn::InterleaveLower(d, x.c2, zero);
  const Row yw2 = hn::InterleaveUpper(d, x.c2, zero);
  return {hn::OddEvenBlocks(hn::SwapAdjacentBlocks(xz2), xz01),
          hn::OddEvenBlocks(hn::SwapAdjacentBlocks(yw2), yw01),
          hn::OddEvenBlocks(xz2, hn::SwapAdjacentBlocks(xz01))};
}

/// Ones on the diagonal of a block.
struct Unit {
  Row e0, e1, e2;
};
HWY_INLINE Unit unit() {
  const Four d;
  alignas(32) static constexpr double rows[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  return {hn::Load(d, rows), hn::Load(d, rows + 4), hn::Load(d, rows + 8)};
}

/// Y + X^T + (tr(X) + diagonal) I
HWY_INLINE Block whole_block(const Block& y, const Block& x, double diagonal, const Unit& e) {
  const Four d;
  const Row on_diagonal = hn::MulAdd(x.c0, e.e0, hn::MulAdd(x.c1, e.e1, hn::Mul(x.c2, e.e2)));
  const Row trace = hn::Add(hn::SumOfLanes(d, on_diagonal), hn::Set(d, diagonal));
  const Block t = transposed(x);
  return {hn::MulAdd(trace, e.e0, hn::Add(y.c0, t.c0)), hn::MulAdd(trace, e.e1, hn::Add(y.c1, t.c1)),
          hn::MulAdd(trace, e.e2, hn::Add(y.c2, t.c2))};
}

HWY_INLINE Block times(double s, const Block& x) {
  const Row factor = hn::Set(Four(), s);
  return {hn::Mul(factor, x.c0), hn::Mul(factor, x.c1), hn::Mul(factor, x.c2)};
}

/// r X and X of a block, added up over its terms.
struct Sums {
  Block y, x;
};

HWY_INLINE Sums sum_terms(const BlockTerms& terms, std::size_t block) {
  Block x = zero_block();
  const std::uint32_t end = terms.term_begin[block + 1];
  for (std::uint32_t t = terms.term_begin[block]; t < end; ++t) {
    const std::uint32_t term = terms.terms[t];
    add_outer(load(terms.gradients[term >> 2]), terms.gradients[(term >> 4 << 2) | (term & 3)], x);
  }
  if (end == terms.term_begin[block]) return {x, x};
  return {times(terms.ratios[terms.terms[end - 1] >> 4], x), x};
}

HWY_INLINE Sums sum_mixed_terms(const BlockTerms& terms, std::size_t block) {
  Sums sums{zero_block(), zero_block()};
  for (std::uint32_t t = terms.term_begin[block]; t < terms.term_begin[block + 1]; ++t) {
    const std::uint32_t term = terms.terms[t];
    Block one = zero_block();
    add_outer(load(terms.gradients[term >> 2]), terms.gradients[(term >> 4 << 2) | (term & 3)], one);
    const Row ratio = hn::Set(Four(), terms.ratios[term >> 4]);
    sums.x = {hn::Add(sums.x.c0, one.c0), hn::Add(sums.x.c1, one.c1), hn::Add(sums.x.c2, one.c2)};
    sums.y = {hn::MulAdd(ratio, one.c0, sums.y.c0), hn::MulAdd(ratio, one.c1, sums.y.c1),
              hn::MulAdd(ratio, one.c2, sums.y.c2)};
  }
  return sums;
}

void assemble_rows(const BlockTerms& terms, BlockValue* values, std::size_t begin, std::size_t end) {
  const Unit e = unit();
  for (std::size_t row = begin; row < end; ++row) {
    const std::size_t last = std::size_t{2} * terms.pair_begin[row + 1];
    for (std::size_t block = std::size_t{2} * terms.pair_begin[row]; block < last; ++block) {
      const Sums sums = terms.mixed[row] != 0 ? sum_mixed_terms(terms, block) : sum_terms(terms, block);
      const double diagonal = block == terms.diagonal_block[row] ? terms.diagonal[row] : 0.0;
      const Block whole = whole_block(sums.y, sums.x, diagonal, e);
      BlockValue* out = values + 24 * (block / 2) + 4 * (block % 2);
      store_values(whole.c0, out);
      store_values(whole.c1, out + 8);
      store_values(whole.c2, out + 16);
    }
  }
}

/// Lane `lane` of each four lanes, in all of them.
template <std::size_t lane, class D>
HWY_INLINE hn::Vec<D> spread(D d, hn::Vec<D> v) {
  alignas(64) static constexpr std::int64_t places[8] = {lane,     lane,     lane,     lane,
                                                         lane + 4, lane + 4, lane + 4, lane + 4};
  return hn::TableLookupLanes(v, hn::SetTableIndices(d, places));
}

/// Product of a matrix, column by column, with a row.
HWY_INLINE Row product(const double* columns, Row x) {
  const Four d;
  const Row first = hn::Mul(hn::Load(d, columns), spread<0>(d, x));
  const Row second = hn::MulAdd(hn::Load(d, columns + 4), spread<1>(d, x), first);
  return hn::MulAdd(hn::Load(d, columns + 8), spread<2>(d, x), second);
}

void coupling_products(const CouplingTerm* couplings, const Padded3* x, Padded3* products, std::size_t begin,
                       std::size_t end) {
  const Four d;
  for (std::size_t c = begin; c < end; ++c) {
    const CouplingTerm& coupling = couplings[c];
    Row sum = hn::Zero(d);
    for (std::size_t k = 0; k < 5; ++k) {
      const Padded3& row = x[static_cast<std::size_t>(coupling.points[k])];
      sum = hn::MulAdd(hn::Set(d, coupling.coefficients[k]), load(row), sum);
    }
    store(product(coupling.weights.data(), sum), products[c]);
  }
}

HWY_INLINE Row blocks_product(const BlockRows& blocks, const Padded3* x, std::size_t row) {
  const Wide d;
  auto c0 = hn::Zero(d);
  auto c1 = c0;
  auto c2 = c0;
  const std::size_t last = blocks.pair_begin[row + 1];
  for (std::size_t pair = blocks.pair_begin[row]; pair < last; ++pair) {
    const BlockValue* values = blocks.values + 24 * pair;
    const Row first = load(x[blocks.columns[2 * pair]]);
    const Row second = load(x[blocks.columns[2 * pair + 1]]);
#if HWY_MAX_BYTES >= 64
    const auto both = hn::Combine(d, second, first);
    c0 = hn::MulAdd(load_values(d, values), spread<0>(d, both), c0);
    c1 = hn::MulAdd(load_values(d, values + 8), spread<1>(d, both), c1);
    c2 = hn::MulAdd(load_values(d, values + 16), spread<2>(d, both), c2);
#else
    c0 = hn::MulAdd(load_values(d, values), spread<0>(d, first), c0);
    c1 = hn::MulAdd(load_values(d, values + 8), spread<1>(d, first), c1);
    c2 = hn::MulAdd(load_values(d, values + 16), spread<2>(d, first), c2);
    c0 = hn::MulAdd(load_values(d, values + 4), spread<0>(d, second), c0);
    c1 = hn::MulAdd(load_values(d, values + 12), spread<1>(d, second), c1);
    c2 = hn::MulAdd(load_values(d, values + 20), spread<2>(d, second), c2);
#endif
  }
  const auto sum = hn::Add(hn::Add(c0, c1), c2);
#if HWY_MAX_BYTES >= 64
  return hn::Add(hn::LowerHalf(Four(), sum), hn::UpperHalf(Four(), sum));
#else
  return sum;
#endif
}

double multiply_rows(const BlockRows& blocks, const CouplingRows& couplings, const Padded3* x, Padded3* y,
                     std::size_t begin, std::size_t end) {
  const Four d;
  Row inner = hn::Zero(d);
  for (std::size_t row = begin; row < end; ++row) {
    Row sum = blocks_product(blocks, x, row);
    for (std::int32_t e = couplings.begin[row]; e < couplings.begin[row + 1]; ++e) {
      const CouplingEntry& entry = couplings.entries[e];
      sum = hn::MulAdd(hn::Set(d, entry.coefficient), load(couplings.products[entry.coupling]), sum);
    }
    store(sum, y[row]);
    inner = hn::MulAdd(load(x[row]), sum, inner);
  }
  return hn::GetLane(hn::SumOfLanes(d, inner));
}

VectorSums advance_rows(const GradientVectors& v, double step, std::size_t begin, std::size_t end) {
  const Four d;
  const Row factor = hn::Set(d, step);
  Row rr = hn::Zero(d);
  Row rz = hn::Zero(d);
  Row xx = hn::Zero(d);
  for (std::size_t row = begin; row < end; ++row) {
    const Row x = hn::MulAdd(factor, load(v.direction[row]), load(v.solution[row]));
    const Row r = hn::NegMulAdd(factor, load(v.product[row]), load(v.residual[row]));
    const Row z = product(v.inverse_diagonal + 12 * row, r);
    store(x, v.solution[row]);
    store(r, v.residual[row]);
    store(z, v.preconditioned[row]);
    rr = hn::MulAdd(hn::Mul(r, r), hn::Set(d, v.inverse_masses[row]), rr);
    rz = hn::MulAdd(r, z, rz);
    xx = hn::MulAdd(hn::Mul(x, x), hn::Set(d, v.masses[row]), xx);
  }
  return {hn::GetLane(hn::SumOfLanes(d, rr)), hn::GetLane(hn::SumOfLanes(d, rz)),
          hn::GetLane(hn::SumOfLanes(d, xx))};
}

void turn_rows(const GradientVectors& v, double turn, std::size_t begin, std::size_t end) {
  const Row factor = hn::Set(Four(), turn);
  for (std::size_t row = begin; row < end; ++row) {
    store(hn::MulAdd(factor, load(v.direction[row]), load(v.preconditioned[row])), v.direction[row]);
  }
}

#else

using scalar::advance_rows;
using scalar::assemble_rows;
using scalar::coupling_products;
using scalar::multiply_rows;
using scalar::turn_rows;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(assemble_rows);
HWY_EXPORT(coupling_products);
HWY_EXPORT(multiply_rows);
HWY_EXPORT(advance_rows);
HWY_EXPORT(turn_rows);

void assemble_rows(const BlockTerms& terms, BlockValue* values, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(assemble_rows)(terms, values, begin, end);
}
void coupling_products(const CouplingTerm* couplings, const Padded3* x, Padded3* products, std::size_t begin,
                       std::size_t end) {
  HWY_DYNAMIC_DISPATCH(coupling_products)(couplings, x, products, begin, end);
}
double multiply_rows(const BlockRows& blocks, const CouplingRows& couplings, const Padded3* x, Padded3* y,
                     std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(multiply_rows)(blocks, couplings, x, y, begin, end);
}
VectorSums advance_rows(const GradientVectors& vectors, double step, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(advance_rows)(vectors, step, begin, end);
}
void turn_rows(const GradientVectors& vectors, double turn, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(turn_rows)(vectors, turn, begin, end);
}

}  // namespace palpate::simd
#endif

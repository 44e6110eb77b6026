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
/// Three columns of a block.
struct Block {
  Row c0, c1, c2;
};

HWY_INLINE Block load_block(const double* values) {
  const Four d;
  return {hn::Load(d, values), hn::Load(d, values + 8), hn::Load(d, values + 16)};
}
HWY_INLINE void store_block(const Block& block, double* values) {
  const Four d;
  hn::Store(block.c0, d, values);
  hn::Store(block.c1, d, values + 8);
  hn::Store(block.c2, d, values + 16);
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

/// Adds X = a_i a_j^T of each element at a point to its blocks. Element by element, not block by block: how
/// many elements a block has is hard to foresee for the processor.
HWY_INLINE void add_terms(const AssemblyRows& rows, std::size_t row, double* values) {
  const Four d;
  const auto add_outer = [&](Row a, const Padded3& b, Block& x) {
    x.c0 = hn::MulAdd(a, hn::Set(d, b.x), x.c0);
    x.c1 = hn::MulAdd(a, hn::Set(d, b.y), x.c1);
    x.c2 = hn::MulAdd(a, hn::Set(d, b.z), x.c2);
  };
  Block diagonal{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::int32_t i = rows.incidence_begin[row]; i < rows.incidence_begin[row + 1]; ++i) {
    const Incidence& incidence = rows.incidences[i];
    const Padded3& own = rows.gradients[incidence.own];
    const Padded3* corners = rows.gradients + (incidence.own & ~std::uint32_t{3});
    const Row a = load(own);
    add_outer(a, own, diagonal);
    for (std::uint32_t k = 1; k < 4; ++k) {
      double* block = values + incidence.places[k];
      Block x = load_block(block);
      add_outer(a, corners[(incidence.own + k) & 3], x);
      store_block(x, block);
    }
  }
  store_block(diagonal, values + rows.incidences[rows.incidence_begin[row]].places[0]);
}

/// Adds r X + X^T + tr(X) I of each element at a point, where r differs.
HWY_INLINE void add_mixed_terms(const AssemblyRows& rows, std::size_t row, double* values, const Unit& e) {
  const Four d;
  for (std::int32_t i = rows.incidence_begin[row]; i < rows.incidence_begin[row + 1]; ++i) {
    const Incidence& incidence = rows.incidences[i];
    const Row a = load(rows.gradients[incidence.own]);
    const Padded3* other = rows.gradients + (incidence.own & ~std::uint32_t{3});
    const double ratio = rows.ratios[incidence.own / 4];
    for (std::size_t j = 0; j < 4; ++j) {
      const Padded3& b = other[(incidence.own + j) & 3];
      const Block x{hn::Mul(a, hn::Set(d, b.x)), hn::Mul(a, hn::Set(d, b.y)), hn::Mul(a, hn::Set(d, b.z))};
      const Block one = whole_block(times(ratio, x), x, 0.0, e);
      const Block sum = load_block(values + incidence.places[j]);
      store_block({hn::Add(sum.c0, one.c0), hn::Add(sum.c1, one.c1), hn::Add(sum.c2, one.c2)},
                  values + incidence.places[j]);
    }
  }
}

/// X becomes r X + X^T + tr(X) I, in all blocks of a row: of a whole pair at once where lanes allow, as
/// nothing moves between the fours.
HWY_INLINE void finish_row(const AssemblyRows& rows, std::size_t row, double* values) {
  const Wide d;
  const std::size_t lanes = hn::Lanes(d);
  alignas(64) static constexpr double ones[3][8] = {
      {1, 0, 0, 0, 1, 0, 0, 0}, {0, 1, 0, 0, 0, 1, 0, 0}, {0, 0, 1, 0, 0, 0, 1, 0}};
  const auto e0 = hn::Load(d, ones[0]);
  const auto e1 = hn::Load(d, ones[1]);
  const auto e2 = hn::Load(d, ones[2]);
  const auto zero = hn::Zero(d);
  const auto ratio = hn::Set(d, rows.ratios[rows.incidences[rows.incidence_begin[row]].own / 4]);
  const std::size_t pairs = rows.pair_begin[row + 1] - rows.pair_begin[row];
  for (std::size_t k = 0; k < 8 * pairs; k += lanes) {
    double* place = values + 24 * (k / 8) + k % 8;
    const auto c0 = hn::Load(d, place);
    const auto c1 = hn::Load(d, place + 8);
    const auto c2 = hn::Load(d, place + 16);
    const auto on_diagonal = hn::MulAdd(c0, e0, hn::MulAdd(c1, e1, hn::Mul(c2, e2)));
    const auto half = hn::Add(on_diagonal, hn::SwapAdjacentBlocks(on_diagonal));
    const auto trace = hn::Add(half, hn::Shuffle01(half));
    const auto xz01 = hn::InterleaveLower(d, c0, c1);
    const auto yw01 = hn::InterleaveUpper(d, c0, c1);
    const auto xz2 = hn::InterleaveLower(d, c2, zero);
    const auto yw2 = hn::InterleaveUpper(d, c2, zero);
    const auto t0 = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(xz2), xz01);
    const auto t1 = hn::OddEvenBlocks(hn::SwapAdjacentBlocks(yw2), yw01);
    const auto t2 = hn::OddEvenBlocks(xz2, hn::SwapAdjacentBlocks(xz01));
    hn::Store(hn::MulAdd(trace, e0, hn::MulAdd(ratio, c0, t0)), d, place);
    hn::Store(hn::MulAdd(trace, e1, hn::MulAdd(ratio, c1, t1)), d, place + 8);
    hn::Store(hn::MulAdd(trace, e2, hn::MulAdd(ratio, c2, t2)), d, place + 16);
  }
}

HWY_INLINE void add_to_diagonal(const AssemblyRows& rows, std::size_t row, double* values) {
  const std::size_t place = rows.diagonal_block[row] - std::size_t{2} * rows.pair_begin[row];
  double* block = values + 24 * (place / 2) + 4 * (place % 2);
  for (std::size_t k = 0; k < 3; ++k) block[9 * k] += rows.diagonal[row];
}

void assemble_rows(const AssemblyRows& rows, double* values, std::size_t begin, std::size_t end) {
  const Unit e = unit();
  for (std::size_t row = begin; row < end; ++row) {
    const std::size_t first = rows.pair_begin[row];
    const std::size_t last = rows.pair_begin[row + 1];
    if (first == last) continue;
    double* own = values + 24 * first;
    for (std::size_t k = 0; k < 24 * (last - first); k += 4) hn::Store(hn::Zero(Four()), Four(), own + k);
    if (rows.mixed[row] != 0) {
      add_mixed_terms(rows, row, own, e);
    } else {
      add_terms(rows, row, own);
      finish_row(rows, row, own);
    }
    add_to_diagonal(rows, row, own);
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
    const double* values = blocks.values + 24 * pair;
    const Row first = load(x[blocks.columns[2 * pair]]);
    const Row second = load(x[blocks.columns[2 * pair + 1]]);
#if HWY_MAX_BYTES >= 64
    const auto both = hn::Combine(d, second, first);
    c0 = hn::MulAdd(hn::Load(d, values), spread<0>(d, both), c0);
    c1 = hn::MulAdd(hn::Load(d, values + 8), spread<1>(d, both), c1);
    c2 = hn::MulAdd(hn::Load(d, values + 16), spread<2>(d, both), c2);
#else
    c0 = hn::MulAdd(hn::Load(d, values), spread<0>(d, first), c0);
    c1 = hn::MulAdd(hn::Load(d, values + 8), spread<1>(d, first), c1);
    c2 = hn::MulAdd(hn::Load(d, values + 16), spread<2>(d, first), c2);
    c0 = hn::MulAdd(hn::Load(d, values + 4), spread<0>(d, second), c0);
    c1 = hn::MulAdd(hn::Load(d, values + 12), spread<1>(d, second), c1);
    c2 = hn::MulAdd(hn::Load(d, values + 20), spread<2>(d, second), c2);
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
  Row by_mass = hn::Zero(d);
  Row rz = hn::Zero(d);
  Row xx = hn::Zero(d);
  for (std::size_t row = begin; row < end; ++row) {
    const Row x = hn::MulAdd(factor, load(v.direction[row]), load(v.solution[row]));
    const Row r = hn::NegMulAdd(factor, load(v.product[row]), load(v.residual[row]));
    const Row z = product(v.inverse_diagonal + 12 * row, r);
    store(x, v.solution[row]);
    store(r, v.residual[row]);
    store(z, v.preconditioned[row]);
    const Row square = hn::Mul(r, r);
    rr = hn::Add(rr, square);
    by_mass = hn::MulAdd(square, hn::Set(d, v.inverse_masses[row]), by_mass);
    rz = hn::MulAdd(r, z, rz);
    xx = hn::MulAdd(hn::Mul(x, x), hn::Set(d, v.masses[row]), xx);
  }
  return {hn::GetLane(hn::SumOfLanes(d, rr)), hn::GetLane(hn::SumOfLanes(d, by_mass)),
          hn::GetLane(hn::SumOfLanes(d, rz)), hn::GetLane(hn::SumOfLanes(d, xx))};
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

void assemble_rows(const AssemblyRows& rows, double* values, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(assemble_rows)(rows, values, begin, end);
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

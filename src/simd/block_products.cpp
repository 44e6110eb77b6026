#include "simd/block_products.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/block_products.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

namespace {
namespace hn = hwy::HWY_NAMESPACE;

// No masked vectors of eight: a result is often read soon after it was written, and loads do not get the
// values of masked stores before these are in the cache.
using Wide = hn::CappedTag<double, 4>;
constexpr std::size_t lanes = hn::MaxLanes(Wide());

/// A row of six numbers.
template <std::size_t vector_lanes>
struct Row;

template <>
struct Row<4> {
  using Tail = hn::CappedTag<double, 2>;
  hn::Vec<Wide> v;
  hn::Vec<Tail> tail;

  HWY_INLINE static Row load(const double* values) {
    return {hn::LoadU(Wide(), values), hn::LoadU(Tail(), values + 4)};
  }
  HWY_INLINE static Row all(double value) { return {hn::Set(Wide(), value), hn::Set(Tail(), value)}; }
  HWY_INLINE void store(double* values) const {
    hn::StoreU(v, Wide(), values);
    hn::StoreU(tail, Tail(), values + 4);
  }
  [[nodiscard]] HWY_INLINE Row times(const Row& b) const { return {hn::Mul(v, b.v), hn::Mul(tail, b.tail)}; }
  [[nodiscard]] HWY_INLINE Row plus(const Row& b) const { return {hn::Add(v, b.v), hn::Add(tail, b.tail)}; }
};

template <>
struct Row<2> {
  std::array<hn::Vec<Wide>, 3> v;

  HWY_INLINE static Row load(const double* values) {
    return {{hn::LoadU(Wide(), values), hn::LoadU(Wide(), values + 2), hn::LoadU(Wide(), values + 4)}};
  }
  HWY_INLINE static Row all(double value) {
    const auto same = hn::Set(Wide(), value);
    return {{same, same, same}};
  }
  HWY_INLINE void store(double* values) const {
    for (std::size_t p = 0; p < 3; ++p) hn::StoreU(v[p], Wide(), values + 2 * p);
  }
  [[nodiscard]] HWY_INLINE Row times(const Row& b) const {
    return {{hn::Mul(v[0], b.v[0]), hn::Mul(v[1], b.v[1]), hn::Mul(v[2], b.v[2])}};
  }
  [[nodiscard]] HWY_INLINE Row plus(const Row& b) const {
    return {{hn::Add(v[0], b.v[0]), hn::Add(v[1], b.v[1]), hn::Add(v[2], b.v[2])}};
  }
};

template <std::size_t rows, std::size_t inner, bool transposed>
HWY_INLINE void add_all(const double* first, const double* second, const BlockPair* pairs, std::size_t count,
                        double* results) {
  using R = Row<lanes>;
  for (std::size_t t = 0; t < count; ++t) {
    const double* a = first + rows * inner * pairs[t].first;
    const double* b = second + 6 * inner * pairs[t].second;
    double* result = results + 6 * rows * pairs[t].place;
    std::array<R, inner> row;
    for (std::size_t k = 0; k < inner; ++k) row[k] = R::load(b + 6 * k);
    for (std::size_t i = 0; i < rows; ++i) {
      const auto factor = [&](std::size_t k) { return R::all(a[transposed ? rows * k + i : inner * i + k]); };
      R sum = factor(0).times(row[0]);
      for (std::size_t k = 1; k < inner; ++k) sum = sum.plus(factor(k).times(row[k]));
      R::load(result + 6 * i).plus(sum).store(result + 6 * i);
    }
  }
}

}  // namespace

void add_block_products(BlockProduct kind, const double* first, const double* second, const BlockPair* pairs,
                        std::size_t count, double* results) {
  switch (kind) {
    case BlockProduct::three:
      return add_all<3, 3, false>(first, second, pairs, count, results);
    case BlockProduct::six:
      return add_all<6, 6, false>(first, second, pairs, count, results);
    case BlockProduct::three_transposed:
      return add_all<3, 3, true>(first, second, pairs, count, results);
    case BlockProduct::six_transposed:
      return add_all<6, 6, true>(first, second, pairs, count, results);
    case BlockProduct::tall_transposed:
      return add_all<6, 3, true>(first, second, pairs, count, results);
  }
}

#else

using scalar::add_block_products;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(add_block_products);

void add_block_products(BlockProduct kind, const double* first, const double* second, const BlockPair* pairs,
                        std::size_t count, double* results) {
  HWY_DYNAMIC_DISPATCH(add_block_products)(kind, first, second, pairs, count, results);
}

namespace scalar {
namespace {

void add_product(std::size_t rows, std::size_t inner, bool transposed, const double* a, const double* b,
                 double* result) {
  for (std::size_t i = 0; i < rows; ++i) {
    for (std::size_t j = 0; j < 6; ++j) {
      double sum = 0.0;
      for (std::size_t k = 0; k < inner; ++k)
        sum += a[transposed ? rows * k + i : inner * i + k] * b[6 * k + j];
      result[6 * i + j] += sum;
    }
  }
}

}  // namespace

void add_block_products(BlockProduct kind, const double* first, const double* second, const BlockPair* pairs,
                        std::size_t count, double* results) {
  const bool three = kind == BlockProduct::three || kind == BlockProduct::three_transposed;
  const std::size_t rows = three ? 3 : 6;
  const std::size_t inner = three || kind == BlockProduct::tall_transposed ? 3 : 6;
  const bool transposed = kind != BlockProduct::three && kind != BlockProduct::six;
  for (std::size_t t = 0; t < count; ++t) {
    add_product(rows, inner, transposed, first + rows * inner * pairs[t].first,
                second + 6 * inner * pairs[t].second, results + 6 * rows * pairs[t].place);
  }
}

}  // namespace scalar
}  // namespace palpate::simd
#endif

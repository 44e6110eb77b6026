#include "simd/factor_columns.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/factor_columns.cpp"
#include <hwy/foreach_target.h>
// Highway wants its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using Four = hn::FixedTag<float, 4>;
using FourV = hn::Vec<Four>;

/// Sums of x, y and z of three vectors, one a lane; w does not count.
HWY_INLINE FourV sums_of(FourV a, FourV b, FourV c) {
  const Four d;
  const hn::Repartition<double, Four> pairs;
  const auto ab = hn::BitCast(pairs, hn::InterleaveLower(d, a, b));
  const auto c0 = hn::BitCast(pairs, hn::InterleaveLower(d, c, c));
  const auto ab2 = hn::BitCast(pairs, hn::InterleaveUpper(d, a, b));
  const auto c2 = hn::BitCast(pairs, hn::InterleaveUpper(d, c, c));
  const FourV x = hn::BitCast(d, hn::InterleaveLower(pairs, ab, c0));
  const FourV y = hn::BitCast(d, hn::InterleaveUpper(pairs, ab, c0));
  const FourV z = hn::BitCast(d, hn::InterleaveLower(pairs, ab2, c2));
  return hn::Add(x, hn::Add(y, z));
}

HWY_INLINE FourV block_product(const float* block, FourV x) {
  const Four d;
  const FourV first = hn::Mul(hn::LoadU(d, block), hn::Broadcast<0>(x));
  const FourV second = hn::MulAdd(hn::LoadU(d, block + 3), hn::Broadcast<1>(x), first);
  return hn::MulAdd(hn::LoadU(d, block + 6), hn::Broadcast<2>(x), second);
}

HWY_INLINE void solve_forward(const FactorColumns& columns, Quad* b, std::size_t j) {
  const Four d;
  const FourV y = block_product(columns.inverses + 9 * j, hn::Load(d, &b[j].x));
  hn::Store(y, d, &b[j].x);
  for (std::size_t k = columns.begin[j]; k < columns.begin[j + 1]; ++k) {
    float* target = &b[columns.rows[k]].x;
    hn::Store(hn::Sub(hn::Load(d, target), block_product(columns.blocks + 9 * k, y)), d, target);
  }
}

HWY_INLINE void solve_backward(const FactorColumns& columns, Quad* b, std::size_t j) {
  const Four d;
  // Two sums of each, as one would wait for itself.
  std::array<FourV, 6> s;
  s.fill(hn::Zero(d));
  const auto add = [&](std::size_t k, std::size_t first) {
    const FourV x = hn::Load(d, &b[columns.rows[k]].x);
    const float* block = columns.blocks + 9 * k;
    s[first] = hn::MulAdd(hn::LoadU(d, block), x, s[first]);
    s[first + 1] = hn::MulAdd(hn::LoadU(d, block + 3), x, s[first + 1]);
    s[first + 2] = hn::MulAdd(hn::LoadU(d, block + 6), x, s[first + 2]);
  };
  const std::size_t last = columns.begin[j + 1];
  std::size_t k = columns.begin[j];
  for (; k + 2 <= last; k += 2) {
    add(k, 0);
    add(k + 1, 3);
  }
  if (k < last) add(k, 0);
  const FourV s0 = hn::Add(s[0], s[3]);
  const FourV s1 = hn::Add(s[1], s[4]);
  const FourV s2 = hn::Add(s[2], s[5]);
  const FourV y = hn::Sub(hn::Load(d, &b[j].x), sums_of(s0, s1, s2));
  const float* g = columns.inverses + 9 * j;
  const FourV x =
      sums_of(hn::Mul(hn::LoadU(d, g), y), hn::Mul(hn::LoadU(d, g + 3), y), hn::Mul(hn::LoadU(d, g + 6), y));
  hn::Store(x, d, &b[j].x);
}

void solve_columns(const FactorColumns& columns, Quad* b, ColumnRange first, ColumnRange second) {
  const std::size_t both = std::min(first.size(), second.size());
  for (std::size_t i = 0; i < both; ++i) {
    solve_forward(columns, b, first.begin + i);
    solve_forward(columns, b, second.begin + i);
  }
  for (std::size_t j = first.begin + both; j < first.end; ++j) solve_forward(columns, b, j);
  for (std::size_t j = second.begin + both; j < second.end; ++j) solve_forward(columns, b, j);
  for (std::size_t j = first.end; j-- > first.begin + both;) solve_backward(columns, b, j);
  for (std::size_t j = second.end; j-- > second.begin + both;) solve_backward(columns, b, j);
  for (std::size_t i = both; i-- > 0;) {
    solve_backward(columns, b, first.begin + i);
    solve_backward(columns, b, second.begin + i);
  }
}

using Matrix = std::array<FloatV, 9>;

HWY_INLINE FloatV cofactor(const Matrix& m, std::size_t i, std::size_t j) {
  const std::size_t a = (i + 1) % 3;
  const std::size_t b = (i + 2) % 3;
  const std::size_t c = (j + 1) % 3;
  const std::size_t e = (j + 2) % 3;
  return hn::MulSub(m[3 * a + c], m[3 * b + e], hn::Mul(m[3 * a + e], m[3 * b + c]));
}

/// X <- (X + X^-T) / 2
HWY_INLINE void polar_step(Matrix& m) {
  const Floats d;
  Matrix c;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) c[3 * i + j] = cofactor(m, i, j);
  }
  const FloatV det = hn::MulAdd(m[0], c[0], hn::MulAdd(m[1], c[1], hn::Mul(m[2], c[2])));
  const FloatV half = hn::Set(d, 0.5F);
  const FloatV inverse = hn::Div(half, det);
  for (std::size_t k = 0; k < 9; ++k) m[k] = hn::MulAdd(inverse, c[k], hn::Mul(half, m[k]));
}

void find_rotations(const TurnedRows& rows, const Quad* positions, std::size_t begin, std::size_t end) {
  const Floats d;
  constexpr std::array<float, 9> unit{1, 0, 0, 0, 1, 0, 0, 0, 1};
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; i += float_lanes) {
    const std::size_t slice = i / slice_rows;
    const std::size_t lane = i % slice_rows;
    const QuadLanes own = load_rows_of(positions + i);
    Matrix f;
    f.fill(hn::Zero(d));
    for (std::size_t slot = rows.slot_begin[slice]; slot < rows.slot_begin[slice + 1]; ++slot) {
      const QuadLanes other = load_quads(positions, rows.columns + slice_rows * slot + lane);
      const std::array<FloatV, 3> u{hn::Sub(other.x, own.x), hn::Sub(other.y, own.y),
                                    hn::Sub(other.z, own.z)};
      for (std::size_t k = 0; k < 3; ++k) {
        const FloatV e = hn::LoadU(d, rows.edges + slice_values * slot + slice_rows * k + lane);
        for (std::size_t r = 0; r < 3; ++r) f[3 * r + k] = hn::MulAdd(u[r], e, f[3 * r + k]);
      }
    }
    const FloatV det = hn::MulAdd(f[0], cofactor(f, 0, 0),
                                  hn::MulAdd(f[1], cofactor(f, 0, 1), hn::Mul(f[2], cofactor(f, 0, 2))));
    const auto good = hn::And(hn::Gt(det, hn::Set(d, 0.1F)), hn::Lt(det, hn::Set(d, 10.0F)));
    for (std::size_t k = 0; k < 9; ++k) f[k] = hn::IfThenElse(good, f[k], hn::Set(d, unit[k]));
    for (int step = 0; step < 3; ++step) polar_step(f);
    for (std::size_t k = 0; k < 9; ++k)
      hn::StoreU(f[k], d, rows.rotations + slot_values * slice + slice_rows * k + lane);
  }
}

HWY_INLINE Matrix load_rotation(const TurnedRows& rows, std::size_t row) {
  const Floats d;
  const float* from = rows.rotations + slot_values * (row / slice_rows) + row % slice_rows;
  Matrix m;
  for (std::size_t k = 0; k < 9; ++k) m[k] = hn::LoadU(d, from + slice_rows * k);
  return m;
}

void turn_back(const TurnedRows& rows, const float* r, Quad* quads, std::size_t begin, std::size_t end) {
  const Floats d;
  alignas(64) std::array<Quad, float_lanes> turned;
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; i += float_lanes) {
    const Matrix m = load_rotation(rows, i);
    const float* from = r + slice_values * (i / slice_rows) + i % slice_rows;
    const FloatV taken = hn::LoadU(d, rows.taken + i);
    const FloatV x = hn::Mul(taken, hn::LoadU(d, from));
    const FloatV y = hn::Mul(taken, hn::LoadU(d, from + slice_rows));
    const FloatV z = hn::Mul(taken, hn::LoadU(d, from + 2 * slice_rows));
    const auto entry = [&](std::size_t k) {
      return hn::MulAdd(m[k], x, hn::MulAdd(m[k + 3], y, hn::Mul(m[k + 6], z)));
    };
    store_rows_of({entry(0), entry(1), entry(2), taken}, turned.data());
    for (std::size_t k = 0; k < float_lanes; ++k) quads[rows.places[i + k]] = turned[k];
  }
}

double turn_forth(const TurnedRows& rows, const float* r, const Quad* quads, float* z, std::size_t begin,
                  std::size_t end) {
  const Floats d;
  Sum inner;
  for (std::size_t i = begin * slice_rows; i < end * slice_rows; i += float_lanes) {
    const Matrix m = load_rotation(rows, i);
    const QuadLanes q = load_quads(quads, rows.places + i);
    const std::size_t place = slice_values * (i / slice_rows) + i % slice_rows;
    const auto taken = hn::Gt(hn::LoadU(d, rows.taken + i), hn::Zero(d));
    FloatV sum = hn::Zero(d);
    for (std::size_t k = 0; k < 3; ++k) {
      const FloatV turned =
          hn::MulAdd(m[3 * k], q.x, hn::MulAdd(m[3 * k + 1], q.y, hn::Mul(m[3 * k + 2], q.z)));
      float* target = z + place + slice_rows * k;
      const FloatV value = hn::IfThenElse(taken, turned, hn::LoadU(d, target));
      hn::StoreU(value, d, target);
      sum = hn::MulAdd(hn::LoadU(d, r + place + slice_rows * k), value, sum);
    }
    inner.add(sum);
  }
  return inner.total();
}

#else

using scalar::find_rotations;
using scalar::solve_columns;
using scalar::turn_back;
using scalar::turn_forth;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(solve_columns);
HWY_EXPORT(find_rotations);
HWY_EXPORT(turn_back);
HWY_EXPORT(turn_forth);

void solve_columns(const FactorColumns& columns, Quad* b, ColumnRange first, ColumnRange second) {
  HWY_DYNAMIC_DISPATCH(solve_columns)(columns, b, first, second);
}
void find_rotations(const TurnedRows& rows, const Quad* positions, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(find_rotations)(rows, positions, begin, end);
}
void turn_back(const TurnedRows& rows, const float* r, Quad* quads, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(turn_back)(rows, r, quads, begin, end);
}
double turn_forth(const TurnedRows& rows, const float* r, const Quad* quads, float* z, std::size_t begin,
                  std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(turn_forth)(rows, r, quads, z, begin, end);
}

}  // namespace palpate::simd
#endif

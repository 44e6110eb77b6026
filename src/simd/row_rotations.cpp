// Rotations of rows, fitted to their edges.
#include "simd/gauss_seidel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/row_rotations.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/slice_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using Three = std::array<FloatV, 3>;
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

void find_rotations(const RotationRows& rows, const Quad* positions, float* rotations, std::size_t begin,
                    std::size_t end) {
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
      const Three u{hn::Sub(other.x, own.x), hn::Sub(other.y, own.y), hn::Sub(other.z, own.z)};
      for (std::size_t k = 0; k < 3; ++k) {
        const FloatV e = hn::LoadU(d, rows.edges + slice_values * slot + slice_rows * k + lane);
        for (std::size_t r = 0; r < 3; ++r) f[3 * r + k] = hn::MulAdd(u[r], e, f[3 * r + k]);
      }
    }
    const FloatV det = hn::MulAdd(f[0], cofactor(f, 0, 0),
                                  hn::MulAdd(f[1], cofactor(f, 0, 1), hn::Mul(f[2], cofactor(f, 0, 2))));
    const auto good = hn::And(hn::Gt(det, hn::Set(d, 0.1F)), hn::Lt(det, hn::Set(d, 10.0F)));
    for (std::size_t k = 0; k < 9; ++k) f[k] = hn::IfThenElse(good, f[k], hn::Set(d, unit[k]));
    for (int step = 0; step < 8; ++step) polar_step(f);
    for (std::size_t k = 0; k < 9; ++k)
      hn::StoreU(f[k], d, rotations + slot_values * slice + slice_rows * k + lane);
  }
}

#else

using scalar::find_rotations;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(find_rotations);

void find_rotations(const RotationRows& rows, const Quad* positions, float* rotations, std::size_t begin,
                    std::size_t end) {
  HWY_DYNAMIC_DISPATCH(find_rotations)(rows, positions, rotations, begin, end);
}

}  // namespace palpate::simd
#endif

#include <algorithm>
#include <array>

#include "simd/element_pass.hpp"
#include "simd/hyperelastic_pass.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/tangent_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/tet_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// a d, without fused multiply-adds, so that the twin has the same bits.
HWY_INLINE V plain_dot(V a, V b, V c, const Vec3V& d) {
  return hn::Add(hn::Add(hn::Mul(a, d.x), hn::Mul(b, d.y)), hn::Mul(c, d.z));
}

HWY_INLINE std::array<V, block_stride> load_blocks(const float* blocks) {
  std::array<V, block_stride> b;
  for (std::size_t k = 0; k < block_stride; k += 4) {
    const FourV four = load_float_fours(blocks + k, block_stride);
    b[k] = four.x;
    b[k + 1] = four.y;
    b[k + 2] = four.z;
    b[k + 3] = four.w;
  }
  return b;
}

HWY_INLINE void multiply_lanes(const TangentPass& pass, std::size_t begin, std::size_t e) {
  const std::array<V, block_stride> values = load_blocks(pass.blocks + block_stride * (e - begin));
  std::array<Vec3V, 4> x;
  std::array<Vec3V, 4> y;
  for (std::size_t k = 0; k < 4; ++k) {
    x[k] = load_rows(pass.vectors, pass.corners + 4 * e + k);
    y[k] = {hn::Zero(D()), hn::Zero(D()), hn::Zero(D())};
  }
  const V* b = values.data();
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j, b += 9) {
      const Vec3V d = minus(x[j], x[i]);
      y[i] = plus(y[i], {plain_dot(b[0], b[1], b[2], d), plain_dot(b[3], b[4], b[5], d),
                         plain_dot(b[6], b[7], b[8], d)});
      y[j] = minus(y[j], {plain_dot(b[0], b[3], b[6], d), plain_dot(b[1], b[4], b[7], d),
                          plain_dot(b[2], b[5], b[8], d)});
    }
  }
  for (std::size_t k = 0; k < 4; ++k) store_rows(y[k], pass.products + 16 * (e - begin) + 4 * k);
}

/// The elements before the first whole group are done by the twin.
void tangent_pass(const TangentPass& pass, std::size_t begin, std::size_t end) {
  const std::size_t whole = (begin + element_group - 1) / element_group * element_group;
  if (begin < whole) scalar::tangent_pass(pass, begin, std::min(whole, end));
  for (std::size_t e = whole; e < end; e += lanes) multiply_lanes(pass, begin, e);
}

#else

using scalar::tangent_pass;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(tangent_pass);

void tangent_pass(const TangentPass& pass, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(tangent_pass)(pass, begin, end);
}

namespace scalar {

void tangent_pass(const TangentPass& pass, std::size_t begin, std::size_t end) {
  for (std::size_t e = begin; e < end; ++e) {
    std::array<double, block_stride> values;
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = static_cast<double>(pass.blocks[block_stride * (e - begin) + k]);
    const auto vector = [&](std::size_t k) { return pass.vectors[pass.corners[4 * e + k]]; };
    const std::array<Padded3, 4> x{vector(0), vector(1), vector(2), vector(3)};
    std::array<std::array<double, 4>, 4> y{};
    const double* b = values.data();
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j, b += 9) {
        const std::array d{x[j].x - x[i].x, x[j].y - x[i].y, x[j].z - x[i].z};
        for (std::size_t r = 0; r < 3; ++r) {
          y[i][r] += b[3 * r] * d[0] + b[3 * r + 1] * d[1] + b[3 * r + 2] * d[2];
          y[j][r] -= b[r] * d[0] + b[3 + r] * d[1] + b[6 + r] * d[2];
        }
      }
    }
    for (std::size_t i = 0; i < 4; ++i) std::ranges::copy(y[i], pass.products + 16 * (e - begin) + 4 * i);
  }
}

}  // namespace scalar
}  // namespace palpate::simd
#endif

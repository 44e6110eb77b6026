#include "simd/element_pass.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/stiffness_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/tet_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// r tr(G) I + G + G^T with G = u g^T summed over three corners.
HWY_INLINE Matrix3V response(const std::array<Vec3V, 3>& u, const std::array<Vec3V, 3>& g, V ratio) {
  const auto entry = [](V p, V a, V q, V b, V r, V c) {
    return hn::MulAdd(p, a, hn::MulAdd(q, b, hn::Mul(r, c)));
  };
  const auto row = [&](V p, V q, V r) -> Vec3V {
    return {entry(p, g[0].x, q, g[1].x, r, g[2].x), entry(p, g[0].y, q, g[1].y, r, g[2].y),
            entry(p, g[0].z, q, g[1].z, r, g[2].z)};
  };
  const Vec3V a = row(u[0].x, u[1].x, u[2].x);
  const Vec3V b = row(u[0].y, u[1].y, u[2].y);
  const Vec3V c = row(u[0].z, u[1].z, u[2].z);
  const V bulk = hn::Mul(ratio, hn::Add(a.x, hn::Add(b.y, c.z)));
  const V xy = hn::Add(a.y, b.x);
  const V xz = hn::Add(a.z, c.x);
  const V yz = hn::Add(b.z, c.y);
  return {{hn::Add(hn::Add(a.x, a.x), bulk), xy, xz},
          {xy, hn::Add(hn::Add(b.y, b.y), bulk), yz},
          {xz, yz, hn::Add(hn::Add(c.z, c.z), bulk)}};
}

void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end) {
  const D d;
  for (std::size_t e = begin; e < end; e += lanes) {
    const auto corner = [&](std::size_t k) { return load_rows(pass.vectors, pass.corners + 4 * e + k); };
    const auto turned = [&](std::size_t k) -> Vec3V {
      return {hn::LoadU(d, pass.turned[3 * k] + e), hn::LoadU(d, pass.turned[3 * k + 1] + e),
              hn::LoadU(d, pass.turned[3 * k + 2] + e)};
    };
    const Vec3V origin = corner(0);
    const std::array<Vec3V, 3> u{minus(corner(1), origin), minus(corner(2), origin),
                                 minus(corner(3), origin)};
    const std::array<Vec3V, 3> g{turned(0), turned(1), turned(2)};
    const Matrix3V s = response(u, g, hn::LoadU(d, pass.ratios + e));
    Vec3V sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3V y = product(s, g[k]);
      sum = plus(sum, y);
      store_rows(y, pass.products + 16 * (e - begin) + 4 * (k + 1));
    }
    store_rows(negative(sum), pass.products + 16 * (e - begin));
  }
}

#else

using scalar::stiffness_pass;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(stiffness_pass);

void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(stiffness_pass)(pass, begin, end);
}

namespace scalar {

void stiffness_pass(const StiffnessPass& pass, std::size_t begin, std::size_t end) {
  for (std::size_t e = begin; e < end; ++e) {
    const auto turned = [&](std::size_t k) {
      return std::array{pass.turned[3 * k][e], pass.turned[3 * k + 1][e], pass.turned[3 * k + 2][e]};
    };
    const Padded3& origin = pass.vectors[pass.corners[4 * e]];
    double g[3][3] = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const Padded3& x = pass.vectors[pass.corners[4 * e + k + 1]];
      const std::array u{x.x - origin.x, x.y - origin.y, x.z - origin.z};
      for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 3; ++j) g[i][j] += u[i] * turned(k)[j];
      }
    }
    const double bulk = pass.ratios[e] * (g[0][0] + g[1][1] + g[2][2]);
    Padded3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<double, 3> y{};
      for (std::size_t i = 0; i < 3; ++i) {
        y[i] = bulk * turned(k)[i];
        for (std::size_t j = 0; j < 3; ++j) y[i] += (g[i][j] + g[j][i]) * turned(k)[j];
      }
      double* row = pass.products + 16 * (e - begin) + 4 * (k + 1);
      for (std::size_t i = 0; i < 3; ++i) row[i] = y[i];
      row[3] = 0.0;
      sum = {sum.x - y[0], sum.y - y[1], sum.z - y[2], 0.0};
    }
    double* first = pass.products + 16 * (e - begin);
    first[0] = sum.x;
    first[1] = sum.y;
    first[2] = sum.z;
    first[3] = 0.0;
  }
}

}  // namespace scalar
}  // namespace palpate::simd
#endif

#include "simd/stress_pass.hpp"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/stress_pass.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

#include "simd/eigen_lanes-inl.hpp"
#include "simd/rotation_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_MAX_BYTES >= 32 && !HWY_HAVE_SCALABLE

/// Tensors per group, on every processor.
constexpr std::size_t tensor_group = 8;
static_assert(tensor_group % lanes == 0);

using SixV = std::array<V, 6>;  ///< xx, yy, zz, xy, yz, xz

HWY_INLINE void store(V v, GroupStress::Column& column, std::size_t lane) {
  hn::Store(v, D(), column.data() + lane);
}
HWY_INLINE void store(const SixV& v, std::array<GroupStress::Column, 6>& columns, std::size_t lane) {
  for (std::size_t k = 0; k < 6; ++k) store(v[k], columns[k], lane);
}
HWY_INLINE void store(const Matrix3V& m, std::array<GroupStress::Column, 9>& columns, std::size_t lane) {
  std::size_t k = 0;
  for (const Vec3V* row : {&m.a, &m.b, &m.c}) {
    store(row->x, columns[k++], lane);
    store(row->y, columns[k++], lane);
    store(row->z, columns[k++], lane);
  }
}

/// (F^T F - I) / 2 from H = F - I, without cancellation near rest.
HWY_INLINE SixV green_strain(const Matrix3V& h) {
  const V half = set(0.5);
  const Vec3V x{h.a.x, h.b.x, h.c.x};
  const Vec3V y{h.a.y, h.b.y, h.c.y};
  const Vec3V z{h.a.z, h.b.z, h.c.z};
  const auto mixed = [&](V first, V second, const Vec3V& p, const Vec3V& q) {
    return hn::Mul(half, hn::Add(hn::Add(first, second), dot(p, q)));
  };
  return {hn::MulAdd(half, dot(x, x), h.a.x), hn::MulAdd(half, dot(y, y), h.b.y),
          hn::MulAdd(half, dot(z, z), h.c.z), mixed(h.a.y, h.b.x, x, y),
          mixed(h.b.z, h.c.y, y, z),          mixed(h.a.z, h.c.x, x, z)};
}

/// Symmetric part of P F^T / J.
HWY_INLINE SixV cauchy_stress(const Matrix3V& p, const Matrix3V& f, V det) {
  const V scale = hn::Div(set(1.0), det);
  const V half = hn::Mul(set(0.5), scale);
  const auto mixed = [&](V first, V second) { return hn::Mul(half, hn::Add(first, second)); };
  return {hn::Mul(scale, dot(p.a, f.a)),       hn::Mul(scale, dot(p.b, f.b)),
          hn::Mul(scale, dot(p.c, f.c)),       mixed(dot(p.a, f.b), dot(p.b, f.a)),
          mixed(dot(p.b, f.c), dot(p.c, f.b)), mixed(dot(p.a, f.c), dot(p.c, f.a))};
}

void stress_pass(const StressPass& pass, std::size_t begin, GroupStress& found) {
  const D d;
  for (std::size_t lane = 0; lane < element_group; lane += lanes) {
    const std::size_t e = begin + lane;
    const Matrix3V h = load_displacement_gradient(pass.displacements, pass.corners, pass.inverse_rest, e);
    const Matrix3V f = plus_identity(h);
    Root root = root_of(f);
    const M good = find_root(root);
    const Matrix3V r = rotation_from(root, f);
    const Matrix3V stretch{minus(f.a, r.a), minus(f.b, r.b), minus(f.c, r.c)};
    const V mu = hn::LoadU(d, pass.mu + e);
    const V bulk = hn::Mul(hn::LoadU(d, pass.lambda + e), inner(r, stretch));
    const V twice_mu = hn::Add(mu, mu);
    const Matrix3V p{times_plus(twice_mu, stretch.a, times(bulk, r.a)),
                     times_plus(twice_mu, stretch.b, times(bulk, r.b)),
                     times_plus(twice_mu, stretch.c, times(bulk, r.c))};
    store(f, found.gradient, lane);
    store(green_strain(h), found.strain, lane);
    store(cauchy_stress(p, f, root.det), found.stress, lane);
    const V of_bulk = hn::Mul(hn::Mul(set(0.5), bulk), inner(r, stretch));
    store(hn::MulAdd(mu, inner(stretch, stretch), of_bulk), found.energy_density, lane);
    store(root.det, found.volume_ratio, lane);
    store_flags(hn::Not(good), found.left.data() + lane);
  }
}

/// Moves the larger of two eigenvalues to the front.
HWY_INLINE void sort_two(EigenV& m, std::size_t i, std::size_t j) {
  const M other = hn::Lt(m.diagonal[i], m.diagonal[j]);
  const auto swap = [&](V& a, V& b) {
    const V first = hn::IfThenElse(other, b, a);
    b = hn::IfThenElse(other, a, b);
    a = first;
  };
  swap(m.diagonal[i], m.diagonal[j]);
  swap(m.vectors[i].x, m.vectors[j].x);
  swap(m.vectors[i].y, m.vectors[j].y);
  swap(m.vectors[i].z, m.vectors[j].z);
}

HWY_INLINE Vec3V with_positive_largest(const Vec3V& a) {
  V largest = a.x;
  largest = hn::IfThenElse(hn::Gt(hn::Abs(a.y), hn::Abs(largest)), a.y, largest);
  largest = hn::IfThenElse(hn::Gt(hn::Abs(a.z), hn::Abs(largest)), a.z, largest);
  const V sign = hn::IfThenElse(hn::Lt(largest, hn::Zero(D())), set(-1.0), set(1.0));
  return times(sign, a);
}

/// Loads a vector of tensors from columns of tensor_group entries.
HWY_INLINE EigenV eigen_of_columns(const double* columns) {
  constexpr int sweeps = 5;  // four reach rounding error, except for nearly equal eigenvalues
  const D d;
  SixV a;
  V size = hn::Zero(d);
  V sum = size;
  for (std::size_t k = 0; k < 6; ++k) {
    a[k] = hn::Load(d, columns + tensor_group * k);
    size = hn::Max(size, hn::Abs(a[k]));
    sum = hn::Add(sum, a[k]);
  }
  // Scale, so that squares neither overflow nor underflow.
  const M some = hn::Gt(size, hn::Zero(d));
  const V scale = hn::Div(set(1.0), hn::IfThenElse(some, size, set(1.0)));
  for (V& entry : a) entry = hn::Mul(scale, entry);
  EigenV m = eigen_of<sweeps>({a[0], a[1], a[2], a[3], a[5], a[4]});
  sort_two(m, 0, 1);
  sort_two(m, 1, 2);
  sort_two(m, 0, 1);
  const M finite = hn::IsFinite(sum);
  const V none = set(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < 3; ++k) {
    m.diagonal[k] = hn::IfThenElse(finite, hn::Mul(size, m.diagonal[k]), none);
    const Vec3V v = with_positive_largest(m.vectors[k]);
    m.vectors[k] = {hn::IfThenElse(finite, v.x, none), hn::IfThenElse(finite, v.y, none),
                    hn::IfThenElse(finite, v.z, none)};
  }
  return m;
}

std::size_t symmetric_eigen(std::span<const SymmetricTensor> tensors, std::span<Vec3> values,
                            std::span<std::array<Vec3, 3>> vectors) {
  const D d;
  alignas(64) std::array<double, 12 * tensor_group> columns;
  const auto at_lane = [&](std::size_t column, std::size_t k) { return columns[tensor_group * column + k]; };
  const std::size_t count = tensors.size() / tensor_group * tensor_group;
  for (std::size_t begin = 0; begin < count; begin += tensor_group) {
    for (std::size_t k = 0; k < tensor_group; ++k) {
      const SymmetricTensor& t = tensors[begin + k];
      const std::array entries{t.xx, t.yy, t.zz, t.xy, t.yz, t.xz};
      for (std::size_t c = 0; c < 6; ++c) columns[tensor_group * c + k] = entries[c];
    }
    for (std::size_t lane = 0; lane < tensor_group; lane += lanes) {
      const EigenV m = eigen_of_columns(columns.data() + lane);
      const auto put = [&](V v, std::size_t c) { hn::Store(v, d, columns.data() + tensor_group * c + lane); };
      for (std::size_t k = 0; k < 3; ++k) {
        put(m.diagonal[k], k);
        put(m.vectors[k].x, 3 * k + 3);
        put(m.vectors[k].y, 3 * k + 4);
        put(m.vectors[k].z, 3 * k + 5);
      }
    }
    for (std::size_t k = 0; k < tensor_group; ++k) {
      values[begin + k] = {at_lane(0, k), at_lane(1, k), at_lane(2, k)};
      for (std::size_t v = 0; v < 3; ++v)
        vectors[begin + k][v] = {at_lane(3 * v + 3, k), at_lane(3 * v + 4, k), at_lane(3 * v + 5, k)};
    }
  }
  return count;
}

#else

void stress_pass(const StressPass&, std::size_t, GroupStress& found) {
  found.left.fill(1);
}
std::size_t symmetric_eigen(std::span<const SymmetricTensor>, std::span<Vec3>,
                            std::span<std::array<Vec3, 3>>) {
  return 0;
}

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(stress_pass);
HWY_EXPORT(symmetric_eigen);

void stress_pass(const StressPass& pass, std::size_t begin, GroupStress& found) {
  HWY_DYNAMIC_DISPATCH(stress_pass)(pass, begin, found);
}
std::size_t symmetric_eigen(std::span<const SymmetricTensor> tensors, std::span<Vec3> values,
                            std::span<std::array<Vec3, 3>> vectors) {
  return HWY_DYNAMIC_DISPATCH(symmetric_eigen)(tensors, values, vectors);
}

}  // namespace palpate::simd
#endif

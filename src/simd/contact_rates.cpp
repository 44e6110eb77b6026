#include "simd/contact_rates.hpp"

#include <algorithm>
#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/contact_rates.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR && !HWY_HAVE_SCALABLE

using D = hn::CappedTag<double, direction_lanes>;
using V = hn::Vec<D>;
constexpr std::size_t lanes = hn::MaxLanes(D());
constexpr std::size_t parts = direction_lanes / lanes;

HWY_INLINE V load(const float* values) {
  return hn::PromoteTo(D(), hn::LoadU(hn::Rebind<float, D>(), values));
}

/// J of a contact.
struct Rows {
  const float* x;
  const float* y;
  const float* z;
  HWY_INLINE Rows(const ContactRates& rates, std::size_t contact)
      : x(rates.values + rates.stride * 3 * contact), y(x + rates.stride), z(y + rates.stride) {}
};

/// Three numbers, each in all lanes of a vector.
struct Three {
  V x, y, z;
  HWY_INLINE Three(double a, double b, double c)
      : x(hn::Set(D(), a)), y(hn::Set(D(), b)), z(hn::Set(D(), c)) {}
};

/// a x + b y + c z of the lanes from l on. No fused multiply-adds, since not every target has them.
HWY_INLINE V combination(const Rows& j, std::size_t l, const Three& a) {
  return hn::Add(hn::Add(hn::Mul(a.x, load(j.x + l)), hn::Mul(a.y, load(j.y + l))),
                 hn::Mul(a.z, load(j.z + l)));
}

HWY_INLINE bool is_zero(const double* m) {
  bool zero = true;
  for (std::size_t e = 0; e < 9; ++e) zero = zero && m[e] == 0.0;
  return zero;
}

HWY_INLINE double dot(const float* row, const double* c, std::size_t n) {
  std::array<V, parts> sums;
  sums.fill(hn::Zero(D()));
  for (std::size_t i = 0; i < n; i += direction_lanes) {
    for (std::size_t k = 0; k < parts; ++k) {
      const std::size_t place = i + lanes * k;
      sums[k] = hn::Add(sums[k], hn::Mul(load(row + place), hn::LoadU(D(), c + place)));
    }
  }
  alignas(64) std::array<double, direction_lanes> p;
  for (std::size_t k = 0; k < parts; ++k) hn::Store(sums[k], D(), p.data() + lanes * k);
  return ((p[0] + p[4]) + (p[2] + p[6])) + ((p[1] + p[5]) + (p[3] + p[7]));
}

void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end) {
  for (std::size_t k = begin; k < end; ++k) {
    const Rows j(rates, k);
    u[k] = {dot(j.x, c, rates.n), dot(j.y, c, rates.n), dot(j.z, c, rates.n)};
  }
}

/// Computes `count` vectors of sums from index `first` on, over all contacts, in registers.
template <std::size_t count>
HWY_INLINE void project_part(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                             std::size_t end, std::size_t first) {
  const D d;
  std::array<V, count> sums;
  for (std::size_t i = 0; i < count; ++i) sums[i] = hn::LoadU(d, sum + first + lanes * i);
  for (std::size_t k = begin; k < end; ++k) {
    if (f[k] == Vec3{}) continue;
    const Rows j(rates, k);
    const Three force(f[k].x, f[k].y, f[k].z);
    for (std::size_t i = 0; i < count; ++i)
      sums[i] = hn::Add(sums[i], combination(j, first + lanes * i, force));
  }
  for (std::size_t i = 0; i < count; ++i) hn::StoreU(sums[i], d, sum + first + lanes * i);
}

void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end) {
  constexpr std::size_t many = 4;
  std::size_t first = 0;
  for (; first + many * lanes <= rates.n; first += many * lanes)
    project_part<many>(rates, f, sum, begin, end, first);
  for (; first < rates.n; first += lanes) project_part<1>(rates, f, sum, begin, end, first);
}

/// Rows of J and of H J of a few contacts, for a product of matrices in registers.
struct StiffnessRows {
  static constexpr std::size_t contacts = 8;
  static constexpr std::size_t most = 64;  ///< directions
  using Row = std::array<double, most>;
  alignas(64) std::array<Row, 3 * contacts> left;
  alignas(64) std::array<Row, 3 * contacts> right;
  std::size_t count = 0;

  HWY_INLINE void add(const ContactRates& rates, std::size_t contact, const double* m) {
    const D d;
    const Rows j(rates, contact);
    for (std::size_t l = 0; l < rates.n; l += lanes) {
      hn::Store(load(j.x + l), d, left[count].data() + l);
      hn::Store(load(j.y + l), d, left[count + 1].data() + l);
      hn::Store(load(j.z + l), d, left[count + 2].data() + l);
      for (std::size_t e = 0; e < 3; ++e)
        hn::Store(combination(j, l, {m[3 * e], m[3 * e + 1], m[3 * e + 2]}), d, right[count + e].data() + l);
    }
    count += 3;
  }

  /// sum += left^T right, for the directions from i and from l on.
  template <std::size_t vectors>
  HWY_INLINE void add_tile(double* sum, std::size_t stride, std::size_t i, std::size_t l) const {
    const D d;
    constexpr std::size_t rows = 4;
    std::array<std::array<V, vectors>, rows> sums;
    for (std::size_t k = 0; k < rows; ++k) {
      for (std::size_t v = 0; v < vectors; ++v)
        sums[k][v] = hn::LoadU(d, sum + stride * (i + k) + l + lanes * v);
    }
    for (std::size_t r = 0; r < count; ++r) {
      std::array<V, vectors> b;
      for (std::size_t v = 0; v < vectors; ++v) b[v] = hn::Load(d, right[r].data() + l + lanes * v);
      for (std::size_t k = 0; k < rows; ++k) {
        const V a = hn::Set(d, left[r][i + k]);
        for (std::size_t v = 0; v < vectors; ++v) sums[k][v] = hn::Add(sums[k][v], hn::Mul(a, b[v]));
      }
    }
    for (std::size_t k = 0; k < rows; ++k) {
      for (std::size_t v = 0; v < vectors; ++v)
        hn::StoreU(sums[k][v], d, sum + stride * (i + k) + l + lanes * v);
    }
  }

  HWY_INLINE void add_to(double* sum, std::size_t stride, std::size_t n) {
    for (std::size_t l = 0; l < n;) {
      const bool two = l + 2 * lanes <= n;
      for (std::size_t i = 0; i < n; i += 4) {
        if (two) {
          add_tile<2>(sum, stride, i, l);
        } else {
          add_tile<1>(sum, stride, i, l);
        }
      }
      l += two ? 2 * lanes : lanes;
    }
    count = 0;
  }
};

void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end) {
  StiffnessRows rows;
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    rows.add(rates, k, m);
    if (rows.count == 3 * StiffnessRows::contacts) rows.add_to(sum, rates.stride, rates.n);
  }
  if (rows.count > 0) rows.add_to(sum, rates.stride, rates.n);
}

void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end) {
  const D d;
  for (std::size_t k = begin; k < end; ++k) {
    const double* m = h + 9 * k;
    if (is_zero(m)) continue;
    const Rows j(rates, k);
    const auto x = static_cast<double>(j.x[i]);
    const auto y = static_cast<double>(j.y[i]);
    const auto z = static_cast<double>(j.z[i]);
    const auto times = [&](std::size_t step, std::size_t first) {
      const double* a = m + first;
      return a[0] * x + a[step] * y + a[2 * step] * z;
    };
    const Three left(times(3, 0), times(3, 1), times(3, 2));
    const Three right(times(1, 0), times(1, 3), times(1, 6));
    for (std::size_t l = 0; l < rates.n; l += lanes) {
      hn::StoreU(hn::Add(hn::LoadU(d, row + l), combination(j, l, left)), d, row + l);
      hn::StoreU(hn::Add(hn::LoadU(d, column + l), combination(j, l, right)), d, column + l);
    }
  }
}

#else

using scalar::add_stiffness;
using scalar::add_stiffness_row;
using scalar::combine_rates;
using scalar::project_forces;

#endif

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(combine_rates);
HWY_EXPORT(project_forces);
HWY_EXPORT(add_stiffness);
HWY_EXPORT(add_stiffness_row);

void combine_rates(const ContactRates& rates, const double* c, Vec3* u, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(combine_rates)(rates, c, u, begin, end);
}
void project_forces(const ContactRates& rates, const Vec3* f, double* sum, std::size_t begin,
                    std::size_t end) {
  HWY_DYNAMIC_DISPATCH(project_forces)(rates, f, sum, begin, end);
}
void add_stiffness(const ContactRates& rates, const double* h, double* sum, std::size_t begin,
                   std::size_t end) {
  HWY_DYNAMIC_DISPATCH(add_stiffness)(rates, h, sum, begin, end);
}
void add_stiffness_row(const ContactRates& rates, const double* h, std::size_t i, double* row, double* column,
                       std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(add_stiffness_row)(rates, h, i, row, column, begin, end);
}

}  // namespace palpate::simd
#endif

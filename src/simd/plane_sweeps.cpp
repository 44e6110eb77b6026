#include "simd/plane_sweeps.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/plane_sweeps.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
namespace {

/// As many components as there are lanes.
using Components = hn::CappedTag<double, 4>;
constexpr Components components;

HWY_INLINE hn::Vec<Components> load(const Plane& plane, std::size_t k) {
  return hn::LoadU(components, plane.data() + k);
}
HWY_INLINE void store(hn::Vec<Components> v, Plane& plane, std::size_t k) {
  hn::StoreU(v, components, plane.data() + k);
}

}  // namespace

Plane multiply_planes(const PlaneLists& all, std::size_t begin, std::size_t end) {
  const auto [nodes, links, corrections, search, products] = all;
  Plane sums{};
  for (std::size_t k = 0; k < sums.size(); k += hn::Lanes(components)) {
    auto sum = hn::Zero(components);
    for (std::size_t i = begin; i < end; ++i) {
      const PlaneNode& node = nodes[i];
      const auto own = load(search[i], k);
      auto product = hn::Mul(hn::Set(components, node.diagonal), own);
      for (const PlaneLink* link = links + node.begin; link != links + node.end; ++link)
        product = hn::Sub(product, hn::Mul(hn::Set(components, link->weight), load(search[link->node], k)));
      sum = hn::Add(sum, hn::Mul(product, own));
      store(product, products[i], k);
    }
    store(sum, sums, k);
  }
  return sums;
}

Plane move_planes(const PlaneLists& all, const Plane& stride, std::size_t begin, std::size_t end) {
  const auto [nodes, links, corrections, search, products] = all;
  Plane sums{};
  for (std::size_t k = 0; k < sums.size(); k += hn::Lanes(components)) {
    const auto step = load(stride, k);
    auto sum = hn::Zero(components);
    for (std::size_t i = begin; i < end; ++i) {
      PlaneNode& node = nodes[i];
      store(hn::Add(load(corrections[i], k), hn::Mul(step, load(search[i], k))), corrections[i], k);
      const auto residual = hn::Sub(load(node.residual, k), hn::Mul(step, load(products[i], k)));
      const auto change = hn::Div(residual, hn::Set(components, node.diagonal));
      sum = hn::Add(sum, hn::Mul(residual, change));
      store(residual, node.residual, k);
      store(change, products[i], k);
    }
    store(sum, sums, k);
  }
  return sums;
}

}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {

HWY_EXPORT(multiply_planes);
HWY_EXPORT(move_planes);

Plane multiply_planes(const PlaneLists& all, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(multiply_planes)(all, begin, end);
}

Plane move_planes(const PlaneLists& all, const Plane& stride, std::size_t begin, std::size_t end) {
  return HWY_DYNAMIC_DISPATCH(move_planes)(all, stride, begin, end);
}

}  // namespace palpate::simd
#endif

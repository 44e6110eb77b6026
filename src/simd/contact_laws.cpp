#include "simd/contact_laws.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "simd/contact_laws.cpp"
#include <hwy/foreach_target.h>
// Highway needs its own header after foreach_target.h.
#include <array>
#include <cmath>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace palpate::simd::HWY_NAMESPACE {
#include "simd/contact_laws-inl.hpp"
}  // namespace palpate::simd::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace palpate::simd {
namespace scalar {
namespace plain {
#include "simd/contact_laws-inl.hpp"  // NOLINT(readability-duplicate-include): once a target
}  // namespace plain

void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end) {
  plain::contact_forces(laws, u, base, f, begin, end);
}
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end) {
  plain::contact_derivatives(laws, u, h, begin, end);
}
}  // namespace scalar

HWY_EXPORT(contact_forces);
HWY_EXPORT(contact_derivatives);

void contact_forces(const ContactLawRows& laws, const Vec3* u, const Vec3* base, Vec3* f, std::size_t begin,
                    std::size_t end) {
  HWY_DYNAMIC_DISPATCH(contact_forces)(laws, u, base, f, begin, end);
}
void contact_derivatives(const ContactLawRows& laws, const Vec3* u, double* h, std::size_t begin,
                         std::size_t end) {
  HWY_DYNAMIC_DISPATCH(contact_derivatives)(laws, u, h, begin, end);
}

}  // namespace palpate::simd
#endif

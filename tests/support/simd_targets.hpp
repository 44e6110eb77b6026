#pragma once

#include <cstdint>
#include <functional>
#include <hwy/targets.h>

namespace palpate::test {

/// Compiled targets of this processor with fused multiply-adds and at least four doubles per vector: results
/// have the same bits on all of them.
inline std::int64_t targets_of_same_bits() {
  return hwy::SupportedTargets() & HWY_TARGETS & (HWY_AVX2 | (HWY_AVX2 - 1));
}

/// Calls body(target name) with Highway's dispatch forced to each of some targets, one after the other.
inline void for_each_simd_target(std::int64_t targets, const std::function<void(const char*)>& body) {
  for (std::int64_t left = targets; left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// The same for each target of this processor.
inline void for_each_simd_target(const std::function<void(const char*)>& body) {
  for_each_simd_target(hwy::SupportedTargets(), body);
}

}  // namespace palpate::test

#pragma once

#include <cstdint>
#include <functional>
#include <hwy/targets.h>

namespace palpate::test {

/// Calls body(target name) with dispatch forced to each target that this processor has, in turn.
inline void for_each_simd_target(const std::function<void(const char*)>& body) {
  const std::int64_t all = hwy::SupportedTargets();
  for (std::int64_t left = all; left != 0; left &= left - 1) {
    const std::int64_t target = left & -left;
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    body(hwy::TargetName(target));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace palpate::test

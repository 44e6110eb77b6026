#pragma once

#include <palpate/simulation.hpp>

namespace palpate {

/// Whether parts of a body may have gone through another one in a step: what continuous detection could not
/// stop, or without it, what nobody saw.
inline bool may_have_passed(const StepMetrics& m, bool continuous) {
  return m.passes > 0 || (!continuous && m.pairs_that_could_pass > 0);
}

}  // namespace palpate

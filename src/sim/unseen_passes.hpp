#pragma once

#include <algorithm>

#include <palpate/simulation.hpp>

namespace palpate {

/// Whether the detection left out cells (approximate mode) or clusters (budget), so contacts may be missing.
inline bool may_miss_contacts(const DetectionCounts& counts) {
  return counts.dropped_cells > 0 || counts.completeness < 1.0;
}

/// The smaller of two local thicknesses, of which 0 means none.
inline double thinner(double a, double b) {
  return a > 0.0 && b > 0.0 ? std::min(a, b) : std::max(a, b);
}

/// Whether parts of a body may have gone through another one in a step: what continuous detection could not
/// stop, or without it or without all contacts, what nobody saw. States of a step do not depend on it.
inline bool may_have_passed(const StepMetrics& m, ContinuousDetection continuous) {
  const bool sees_all = continuous != ContinuousDetection::off && !may_miss_contacts(m.detection) &&
                        m.detection.unseen_pairs == 0;
  return m.passes > 0 || (!sees_all && m.pairs_that_could_pass > 0);
}

}  // namespace palpate

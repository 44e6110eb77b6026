#pragma once

#include <palpate/detection.hpp>

#include "contact/contact_table.hpp"
#include "contact/pair_filter.hpp"
#include "contact/surface_normals.hpp"

namespace palpate {

/// What a Simulation needs of its detector beyond what users do: the table, to write states of contacts into
/// it, and the restore after a step that failed.
class DetectorSteps {
 public:
  /// Of the last detection.
  [[nodiscard]] static ContactTable& table(Detector& detector);
  [[nodiscard]] static const ContactTable& table(const Detector& detector);
  /// Which pairs its settings let touch. As long as the detector.
  [[nodiscard]] static PairFilter may_touch(const Detector& detector);
  /// Clusters of the surfaces of its bodies; valid as long as the detector. None without edge contacts.
  [[nodiscard]] static const SurfaceNormals* normals(const Detector& detector);
  /// Keeps the results of the last detection while others follow, and what the next depended on. O(clusters)
  /// with a budget, else O(1).
  static void hold(Detector& detector);
  /// After hold(): makes the results that were held those of the last detection again, without detecting, so
  /// that approximate mode and budgets do not find others; the next detection finds what it would have found
  /// then. Counts of movers are from the last detection that was made. No effect where nothing is held.
  static void swap_back(Detector& detector);
  /// The held results are not needed any more.
  static void release(Detector& detector);
};

}  // namespace palpate

#pragma once

#include <palpate/detection.hpp>

#include "contact/border_edges.hpp"
#include "contact/contact_table.hpp"
#include "contact/crossings.hpp"
#include "contact/pair_filter.hpp"
#include "contact/surface_normals.hpp"

namespace palpate {

/// Results of the last detection that the forces of edges need besides the table.
struct DetectedSurfaces {
  const SurfaceNormals* normals = nullptr;
  const BorderEdges* border_edges = nullptr;
  const Crossings* crossings = nullptr;
};

/// Access for a Simulation beyond the public interface: the table, for states of contacts; and the return
/// to it after a failed step.
class DetectorSteps {
 public:
  /// The table of the last detection.
  [[nodiscard]] static ContactTable& table(Detector& detector);
  [[nodiscard]] static const ContactTable& table(const Detector& detector);
  /// The filter of pairs of bodies that may touch, by the settings. Valid as long as the detector.
  [[nodiscard]] static PairFilter may_touch(const Detector& detector);
  /// From the next detection on, these points do not touch the bodies to which they are tied
  /// (PairFilter::tied_points).
  static void set_tied_points(Detector& detector, std::vector<std::array<Index, 2>> points);
  /// What the forces of edges need; valid as long as the detector. Null without edge contacts.
  [[nodiscard]] static DetectedSurfaces surfaces(const Detector& detector);
  /// Holds the results of the last detection during further ones, and the state that the next detection
  /// depends on. O(clusters) with a budget, otherwise O(1).
  static void hold(Detector& detector);
  /// After hold(): makes the held results those of the last detection again. No detection is made, since
  /// approximate mode and budgets could find other contacts. The next detection then gives the same result as
  /// without those in between. Counts of movers remain those of the last detection that was made. No effect
  /// if nothing is held.
  static void swap_back(Detector& detector);
  /// Discards the held results.
  static void release(Detector& detector);
};

}  // namespace palpate

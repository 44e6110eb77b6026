#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <palpate/detection.hpp>
#include <palpate/settings.hpp>

#include "contact/allowance.hpp"
#include "contact/cluster_queue.hpp"
#include "contact/cost_line.hpp"
#include "contact/deadline.hpp"
#include "contact/recent_cost.hpp"
#include "stopwatch.hpp"

namespace palpate {

/// Applies a Budget to detections: the allowance of each, the reserve for later phases, and the work left
/// undone.
class DetectionBudget {
 public:
  /// Throws Error if the budget is not exactly one number > 0, or detection does not use clusters.
  DetectionBudget(const DetectionSettings& settings, std::size_t bodies);

  /// Call at the start of a detection that may spend `fraction` of the budget. A time limit does not apply to
  /// the first detection, whose cost is unknown.
  void begin(double fraction);
  /// The allowance of this detection; null: no limit.
  [[nodiscard]] Allowance* allowance() { return allowance_ ? &*allowance_ : nullptr; }
  [[nodiscard]] const std::optional<InterestRegion>& region() const { return budget_.region; }
  /// Call after the query of points in tets, before that of border edges.
  void end_points(double seconds);
  /// Maximum number of contacts whose depth is computed; `contacts` unless the budget is in milliseconds.
  [[nodiscard]] std::size_t recomputed_contacts_limit(std::size_t contacts) const;
  /// The allowance for crossings; null: no limit. A budget in time does not limit crossings, since a contact
  /// without them costs more in the depth estimate than the crossings would. So with a limit, fewer and fewer
  /// would be found.
  [[nodiscard]] Allowance* begin_crossings();
  /// The deadline for refining depths; none unless the budget is in time.
  [[nodiscard]] const Deadline& refining() const { return refining_; }
  /// Call at the end of a detection, with the times of its phases; without a limit, queues are empty or null.
  /// \param spared  contacts that did not compute their plane
  void end(const DetectionTimes& times, std::size_t spared, ClusterQueue* tets, ClusterQueue* triangles,
           DetectionCounts& counts);

  /// (n_bodies) 1: not all of its tets (or of its triangles, if it is penetrated) were queried.
  [[nodiscard]] const std::vector<std::uint8_t>& late_bodies() const { return late_bodies_; }
  void set_late_bodies(const std::vector<std::uint8_t>& late) { late_bodies_ = late; }
  /// Time in seconds that a recent detection would have needed to find all contacts and compute few depths.
  [[nodiscard]] const RecentCost& shortest_detection() const { return shortest_detection_; }

 private:
  Budget budget_;
  std::optional<Allowance> allowance_;
  Deadline refining_;
  CostLine later_phases_;          ///< cost of depths and all later phases
  RecentCost shortest_detection_;  ///< s
  double points_seconds_ = 0.0;
  bool begun_ = false;  ///< the first detection is over
  std::vector<std::uint8_t> late_bodies_;
};

}  // namespace palpate

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

/// A Budget over detections: what each may spend, what of it is kept back for the work that follows, and what
/// was left undone.
class DetectionBudget {
 public:
  /// Throws Error where the budget is not one number > 0, or detection is not by clusters.
  DetectionBudget(const DetectionSettings& settings, std::size_t bodies);

  /// At the start of a detection that may spend a fraction of the budget. A time limit does not hold for the
  /// first: its cost is unknown.
  void begin(double fraction);
  /// None: this detection is not limited.
  [[nodiscard]] Allowance* allowance() { return allowance_ ? &*allowance_ : nullptr; }
  [[nodiscard]] const std::optional<InterestRegion>& region() const { return budget_.region; }
  /// After the query of points in tets, before that of border edges.
  void end_points(double seconds);
  /// How many of so many depths there is time to compute. All, unless the budget is in milliseconds.
  [[nodiscard]] std::size_t contacts_anew(std::size_t contacts) const;
  /// What the crossings may spend; none: they are not limited. In time they never are: a contact whose edges
  /// have no crossings costs more in the estimate of depths than they would, so that contacts would be left
  /// with ever fewer.
  [[nodiscard]] Allowance* begin_crossings();
  /// Until when depths are refined; never, but for a budget in time.
  [[nodiscard]] const Deadline& refining() const { return refining_; }
  /// At the end of a detection, with the times of its phases; without a limit, queues are empty or null.
  /// \param spared  contacts that did not compute their plane
  void end(const DetectionTimes& times, std::size_t spared, ClusterQueue* tets, ClusterQueue* triangles,
           DetectionCounts& counts);

  /// (n_bodies) 1: not all of its tets, or of its triangles where it is penetrated, were asked.
  [[nodiscard]] const std::vector<std::uint8_t>& late_bodies() const { return late_bodies_; }
  void set_late_bodies(const std::vector<std::uint8_t>& late) { late_bodies_ = late; }
  /// Budget in seconds that recent detections needed to find all contacts and compute few of their depths
  /// anew.
  [[nodiscard]] const RecentCost& least() const { return least_; }

 private:
  Budget budget_;
  std::optional<Allowance> allowance_;
  Deadline refining_;
  CostLine after_;    ///< of depths that are computed, after the queries
  RecentCost least_;  ///< s
  double points_seconds_ = 0.0;
  bool begun_ = false;  ///< there was a detection
  std::vector<std::uint8_t> late_bodies_;
};

}  // namespace palpate

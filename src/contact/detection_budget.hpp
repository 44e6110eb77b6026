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
#include "contact/edge_query.hpp"
#include "contact/recent_cost.hpp"
#include "contact/work_limit.hpp"

namespace palpate {

/// Applies a Budget to detections: the limit of each query, the order of its work (by queues), the reserve
/// for later phases, and the work left undone.
class DetectionBudget {
 public:
  /// Throws Error if the budget is not exactly one number > 0, or queries do not work on clusters.
  static void check(const DetectionSettings& settings);
  /// \param settings         with a budget that has passed check()
  /// \param tets, triangles  the queues of both queries; must outlive it
  DetectionBudget(const DetectionSettings& settings, std::size_t bodies, ClusterQueue& tets,
                  ClusterQueue& triangles);

  /// Call at the start of a detection that may spend `fraction` of the budget. A time limit does not apply to
  /// the first detection, whose cost is unknown.
  void begin(double fraction);
  /// The limit of the query of points, from now on.
  [[nodiscard]] std::optional<WorkLimit> points_limit();
  [[nodiscard]] const std::optional<InterestRegion>& region() const { return budget_.region; }
  /// Call after the query of points in tets, before that of border edges.
  void end_points(double seconds);
  /// Maximum number of contacts whose depth is computed; `contacts` unless the budget is in milliseconds.
  [[nodiscard]] std::size_t recomputed_contacts_limit(std::size_t contacts) const;
  /// The limit of the query of crossings; none: no limit. A budget in time does not limit crossings, since a
  /// contact without them costs more in the depth estimate than the crossings would. So with a limit, fewer
  /// and fewer would be found.
  [[nodiscard]] std::optional<WorkLimit> begin_crossings();
  /// The deadline of the search of edge contacts; none unless the budget is in time.
  [[nodiscard]] const Deadline& edges_deadline() const { return edges_deadline_; }
  /// Call after the search of edge contacts.
  void end_edges(const EdgeWork& work);
  /// The deadline for refining depths; none unless the budget is in time.
  [[nodiscard]] const Deadline& refining() const { return refining_; }
  /// Whether the limit is a time. Then planes are cached.
  [[nodiscard]] bool is_timed() const { return budget_.milliseconds.has_value(); }
  /// Call at the end of a detection, with the times of its phases. Sets the counts of work left undone.
  /// \param spared  contacts that did not compute their plane
  void end(const DetectionTimes& times, std::size_t spared, DetectionCounts& counts);

  /// (n_bodies) 1: not all of its tets (or of its triangles, if it is penetrated) were queried.
  [[nodiscard]] const std::vector<std::uint8_t>& late_bodies() const { return late_bodies_; }

  /// Stores the state that the next detection depends on, for swap_back(). O(clusters).
  void hold();
  void swap_back();
  /// The state before the last detection, which memories have.
  void save(DetectorMemory& memory) const;
  /// Throws Error if the state of a memory is invalid.
  void recall(const DetectorMemory& memory);

  /// Time in seconds that a recent detection would have needed to find all contacts and compute few depths.
  [[nodiscard]] const RecentCost& shortest_detection() const { return shortest_detection_; }

 private:
  /// State of the clusters: how long they have waited, and whether they found something.
  struct States {
    std::vector<std::uint8_t> tets;
    std::vector<std::uint8_t> triangles;
  };
  struct Held {
    double fraction = 1.0;
    States before;
    States now;
    std::vector<std::uint8_t> late_bodies;
  };

  Budget budget_;
  ClusterQueue& tets_;
  ClusterQueue& triangles_;
  double fraction_ = 1.0;  ///< of the budget, in the last detection
  States before_;          ///< before the last detection
  Held held_;
  std::optional<Allowance> allowance_;
  Deadline refining_;
  Deadline edges_deadline_;
  std::size_t edge_work_ = 0;  ///< EdgeWork::all
  std::size_t late_edges_ = 0;
  RecentCost depths_;              ///< s
  CostLine later_phases_;          ///< cost of depths and all later phases
  RecentCost shortest_detection_;  ///< s
  double points_seconds_ = 0.0;
  bool begun_ = false;  ///< the first detection is over
  std::vector<std::uint8_t> late_bodies_;
};

}  // namespace palpate

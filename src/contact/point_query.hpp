#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <palpate/detection.hpp>

#include "contact/cluster_queue.hpp"
#include "contact/frame.hpp"
#include "contact/point_in_tet.hpp"
#include "contact/query_tally.hpp"
#include "contact/work_limit.hpp"
#include "mesh/clusters.hpp"

namespace palpate {

/// Point-in-volume query: which points are in tets that they may touch (Frame::may_touch). Implementations:
/// clusters of tets in the compact grid (ClusteredPoints), and single tets in any structure (CellPoints).
class PointQuery {
 public:
  struct Update {
    std::optional<Sort> sort;  ///< the sort that was used; none: the structure does not sort
    std::size_t movers = 0;    ///< points whose cell changed since the last detection
  };

  PointQuery() = default;
  PointQuery(const PointQuery&) = delete;
  PointQuery& operator=(const PointQuery&) = delete;
  virtual ~PointQuery() = default;

  /// Puts the points of a frame into the structure.
  /// \param alone  use no data of earlier frames
  virtual Update update(const Frame& frame, bool alone) = 0;
  /// Finds the pairs, after update(). With a limit it may find only some of them.
  virtual void find(const Frame& frame, const std::optional<WorkLimit>& limit) = 0;

  /// The pairs found, in arbitrary order, but the same for every thread count.
  [[nodiscard]] virtual std::span<const PointInTet> found() const = 0;
  /// Counts of the last find().
  [[nodiscard]] virtual QueryTally tally() const = 0;
  /// Memory of the structure.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  [[nodiscard]] virtual std::optional<CuckooCounts> cuckoo() const { return std::nullopt; }
  /// The clusters that it works on; null: single tets.
  [[nodiscard]] virtual const Clusters* clusters() const { return nullptr; }
  /// The queue that a limit needs; null: there is none, and limits have no effect.
  [[nodiscard]] virtual ClusterQueue* queue() { return nullptr; }

  /// Writes the state that the next detection depends on into a memory of the frame.
  virtual void save(const Frame& /*frame*/, DetectorMemory& /*memory*/) const {}
  /// Restores a valid state, after a detection that was made alone at the positions of the saved one.
  virtual void recall(const Frame& /*frame*/, const DetectorMemory& /*memory*/) {}
};

/// The implementation for some settings.
std::unique_ptr<PointQuery> make_point_query(const Bodies& bodies, const DetectionSettings& settings);

}  // namespace palpate

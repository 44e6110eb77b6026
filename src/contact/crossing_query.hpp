#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>

#include <palpate/detection.hpp>

#include "contact/border_edge_view.hpp"
#include "contact/cluster_queue.hpp"
#include "contact/crossing_parameters.hpp"
#include "contact/frame.hpp"
#include "contact/query_tally.hpp"
#include "contact/work_limit.hpp"

namespace palpate {

/// Edge-triangle query (paper 3 and 4): which border edges meet which surface triangles of the body that they
/// leave; triangles with a corner on the edge are left out. Implementations: clusters of triangles
/// (ClusteredCrossings), and single triangles in any structure (CellCrossings).
class CrossingQuery {
 public:
  CrossingQuery() = default;
  CrossingQuery(const CrossingQuery&) = delete;
  CrossingQuery& operator=(const CrossingQuery&) = delete;
  virtual ~CrossingQuery() = default;

  /// Finds the pairs. With a limit it may find only some of them.
  virtual void find(const Frame& frame, const BorderEdgeView& border,
                    const std::optional<WorkLimit>& limit) = 0;

  /// The pairs found, sorted by (border edge, triangle).
  [[nodiscard]] virtual std::span<const EdgeInTriangle> found() const = 0;
  /// Counts of the last find().
  [[nodiscard]] virtual QueryTally tally() const = 0;
  /// Memory of the structure.
  [[nodiscard]] virtual std::size_t bytes() const = 0;
  [[nodiscard]] virtual std::optional<CuckooCounts> cuckoo() const { return std::nullopt; }
  /// The queue that a limit needs; null: there is none, and limits have no effect.
  [[nodiscard]] virtual ClusterQueue* queue() { return nullptr; }
};

/// The implementation for some settings.
std::unique_ptr<CrossingQuery> make_crossing_query(const Bodies& bodies, const DetectionSettings& settings);

}  // namespace palpate

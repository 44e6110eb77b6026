#pragma once

#include "contact/cell_points.hpp"
#include "contact/cluster_query.hpp"
#include "contact/point_query.hpp"
#include "grid/compact.hpp"
#include "grid/point_grid.hpp"

namespace palpate {

/// Point-in-volume query by clusters of tets, in the compact grid of fixed positions (ClusterQuery). Where
/// the lattice has no fixed positions, it asks single tets.
class ClusteredPoints final : public PointQuery {
 public:
  ClusteredPoints(const Bodies& bodies, const DetectionSettings& settings);

  Update update(const Frame& frame, bool alone) override;
  void find(const Frame& frame, const std::optional<WorkLimit>& limit) override;
  [[nodiscard]] std::span<const PointInTet> found() const override {
    return asks_single_tets_ ? single_tets_.found() : query_.found();
  }
  [[nodiscard]] QueryTally tally() const override {
    return asks_single_tets_ ? single_tets_.tally() : query_.tally();
  }
  [[nodiscard]] std::size_t bytes() const override {
    return grid_.bytes() + query_.lists().bytes() + single_tets_.bytes();
  }
  [[nodiscard]] const Clusters* clusters() const override { return &query_.clusters(); }
  [[nodiscard]] ClusterQueue* queue() override { return &query_.queue(); }
  void save(const Frame& frame, DetectorMemory& memory) const override;
  void recall(const Frame& frame, const DetectorMemory& memory) override;

 private:
  [[nodiscard]] bool reuses(const Frame& frame) const { return coherent_ && frame.fixed() != nullptr; }

  Order order_;
  Sort sort_;
  bool coherent_;  ///< uses data of earlier detections
  PointGrid grid_;
  ClusterQuery query_;
  CellPoints<CompactGrid> single_tets_;
  bool asks_single_tets_ = false;  ///< in the last detection
  bool skipped_grid_ = false;      ///< the last detection used no grid
  MoverCount movers_;              ///< where keys are not cells
};

}  // namespace palpate

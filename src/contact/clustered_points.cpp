#include "contact/clustered_points.hpp"

#include <utility>
#include <vector>

namespace palpate {

ClusteredPoints::ClusteredPoints(const Bodies& bodies, const DetectionSettings& settings)
    : order_(settings.order),
      sort_(settings.sort),
      coherent_(settings.coherence && !settings.budget),
      grid_(order_, sort_),
      query_(bodies),
      single_tets_(CompactGrid(order_, sort_)) {}

PointQuery::Update ClusteredPoints::update(const Frame& frame, bool alone) {
  asks_single_tets_ = frame.fixed() == nullptr;
  if (asks_single_tets_) return single_tets_.update(frame, alone);
  const FixedPositions& fixed = *frame.fixed();
  Update update;
  skipped_grid_ = reuses(frame) && !alone &&
                  !query_.begin_frame(frame.grid_threads(), frame.bodies(), fixed, frame.has_new_lattice());
  if (skipped_grid_) {
    grid_.skip(frame.grid_threads(), frame.lattice(), fixed);
  } else {
    update.sort = grid_.build(frame.grid_threads(), frame.lattice(), fixed);
  }
  const CompactGrid& cells = grid_.cells();
  if (!cells.distinguishes_cells()) {
    update.movers = movers_.count(frame);
  } else {
    update.movers = frame.has_new_lattice() ? cells.entries().size() : cells.movers();
  }
  return update;
}

void ClusteredPoints::find(const Frame& frame, const std::optional<WorkLimit>& limit) {
  query_.queue().clear();
  if (asks_single_tets_) return single_tets_.find(frame, limit);
  const PairFilter may_touch = frame.may_touch();
  if (limit) {
    query_.find_within(*limit, frame.threads(), frame.bodies(), frame.positions(), may_touch, grid_,
                       *frame.fixed());
  } else {
    query_.find(frame.threads(), frame.bodies(), frame.positions(), may_touch, grid_, *frame.fixed());
  }
}

void ClusteredPoints::save(const Frame& frame, DetectorMemory& memory) const {
  memory.repairs = grid_.cells().adaptive_switch().repairing();
  memory.skipped_grid = skipped_grid_;
  if (frame.is_swapped()) return;
  for (const simd::FixedPoint& p : query_.listed_points()) memory.reference_points.push_back({p.x, p.y, p.z});
  memory.coherence = query_.plan().numbers();
}

void ClusteredPoints::recall(const Frame& frame, const DetectorMemory& memory) {
  if (reuses(frame)) {
    PointGrid grid(order_, sort_);
    FixedPositions fixed = *frame.fixed();
    if (!memory.reference_points.empty()) {
      fixed.set_points(memory.reference_points);
      grid.build(frame.threads(), frame.lattice(), fixed);
    }
    query_.recall(memory.coherence, frame.threads(), frame.bodies(), frame.may_touch(), grid, fixed);
    skipped_grid_ = memory.skipped_grid;
    if (skipped_grid_) grid_.skip(frame.threads(), frame.lattice(), *frame.fixed());
  }
  grid_.cells().adaptive_switch().set_repairing(memory.repairs);
}

}  // namespace palpate

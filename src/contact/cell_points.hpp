#pragma once

#include <utility>

#include "contact/point_query.hpp"
#include "contact/points_in_tets.hpp"
#include "grid/cuckoo.hpp"

namespace palpate {

/// Point-in-volume query by single tets, in any structure.
template <class Structure>
class CellPoints final : public PointQuery {
 public:
  explicit CellPoints(Structure points) : structure_(std::move(points)) {}

  Update update(const Frame& frame, bool /*alone*/) override {
    Update update;
    update.movers = movers_.count(frame);
    const std::size_t count = frame.positions().size();
    const auto cell_of = [&](Index p) { return frame.cell_of(p); };
    if constexpr (requires { structure_.build_points(frame.threads(), frame.lattice(), count, cell_of); }) {
      update.sort = structure_.build_points(frame.threads(), frame.lattice(), count, cell_of);
    } else {
      structure_.build(frame.threads(), frame.lattice(), count, [&](Index p, auto&& emit) {
        if (const std::optional<Cell> cell = cell_of(p)) emit((*cell)[0], (*cell)[1], (*cell)[2]);
      });
    }
    return update;
  }
  void find(const Frame& frame, const std::optional<WorkLimit>& /*limit*/) override {
    query_.find(frame.threads(), frame.bodies(), frame.positions(), frame.may_touch(), frame.lattice(),
                structure_, frame.slots());
  }

  [[nodiscard]] std::span<const PointInTet> found() const override { return query_.found(); }
  [[nodiscard]] QueryTally tally() const override { return query_.tally(); }
  [[nodiscard]] std::size_t bytes() const override { return structure_.bytes(); }
  [[nodiscard]] std::optional<CuckooCounts> cuckoo() const override { return cuckoo_counts(structure_); }
  void save(const Frame& /*frame*/, DetectorMemory& memory) const override {
    if constexpr (requires { structure_.adaptive_switch(); })
      memory.repairs = structure_.adaptive_switch().repairing();
  }
  void recall(const Frame& /*frame*/, const DetectorMemory& memory) override {
    if constexpr (requires { structure_.adaptive_switch(); })
      structure_.adaptive_switch().set_repairing(memory.repairs);
  }

 private:
  Structure structure_;
  PointsInTets query_;
  MoverCount movers_;
};

}  // namespace palpate

#include "our_query.hpp"

#include <hwy/targets.h>
#include <optional>
#include <stdexcept>

#include "grid/cell_size.hpp"

namespace palpate::bench {

Setting::Setting(const measure::QueryScene& s)
    : scene(s),
      immovable(s.immovable()),
      included(s.places.size(), 1),
      course{s, immovable, Task::points_in_tets} {
  marks.resize(s.places.size());
  for (std::size_t p = 0; p < marks.size(); ++p) marks[p] = at(immovable, s.bodies.body_of_point()[p]);
  parallel::Threads one(1);
  const Clusters clusters = make_tet_clusters(s.bodies);
  cell_size =
      choose_cell_size(one, s.bodies, s.places, included, CellSizeRule::automatic, &clusters).cell_size;
  Box bounds;
  for (const Vec3& p : s.places) bounds.extend(p);
  const Vec3 pad{2 * cell_size, 2 * cell_size, 2 * cell_size};
  lattice = Lattice({bounds.lower - pad, bounds.upper + pad}, cell_size);
}

OurQuery::OurQuery(const Setting& setting, int threads, bool coherent)
    : setting_(&setting),
      coherent_(coherent),
      threads_(threads),
      query_(setting.scene.bodies),
      fixed_(setting.included, setting.marks) {}

std::span<const PointInTet> OurQuery::find(std::span<const Vec3> positions) {
  const Bodies& bodies = setting_->scene.bodies;
  const std::optional<Box> bounds = fixed_.place(threads_, setting_->lattice, positions);
  if (!setting_->lattice.domain().contains(bounds.value().lower)) throw std::runtime_error("domain");
  if (!coherent_ || query_.begin_frame(threads_, bodies, fixed_, is_new_)) {
    grid_.build(threads_, setting_->lattice, fixed_);
  }
  is_new_ = false;
  query_.find(threads_, bodies, positions, setting_->may_touch(), grid_, fixed_);
  return query_.found();
}

ForcedTarget::ForcedTarget(std::int64_t target) : target_(target) {
  if (target_ == 0) return;
  hwy::SetSupportedTargetsForTest(target_);
  hwy::GetChosenTarget().Update(target_);
}

ForcedTarget::~ForcedTarget() {
  if (target_ == 0) return;
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace palpate::bench

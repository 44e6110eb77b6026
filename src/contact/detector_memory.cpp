// The state that later detections depend on. It is saved for a resumed run, or held while a step may still
// fail.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "contact/detector_state.hpp"
#include "contact/detector_steps.hpp"

namespace palpate {

void Detector::State::recall_budget(const DetectorMemory& memory) {
  if (!budget) return;
  std::vector<std::uint8_t>& tets = cluster_query->queue().states();
  std::vector<std::uint8_t>& triangles = crossings.clustered().queue().states();
  if (memory.tet_states.size() != tets.size() || memory.triangle_states.size() != triangles.size() ||
      !(memory.fraction > 0.0) || !(memory.fraction <= 1.0)) {
    throw Error("detector", "memory",
                "a budget state of " + std::to_string(memory.tet_states.size()) + " clusters of tets, " +
                    std::to_string(memory.triangle_states.size()) + " of triangles, fraction " +
                    std::to_string(memory.fraction),
                std::to_string(tets.size()) + " and " + std::to_string(triangles.size()) +
                    " clusters, as in this scene, and a fraction above 0 and up to 1");
  }
  tets = memory.tet_states;
  triangles = memory.triangle_states;
}

void Detector::State::recall_coherence(const DetectorMemory& memory) {
  const std::size_t n = bodies.points_rest().size();
  const auto& points_then = memory.reference_points;
  constexpr std::int32_t most = 1 << 30;  // largest fixed position
  const bool fits = ListPlan::allows(memory.coherence) &&
                    points_then.size() == (memory.coherence[0] != 0 ? n : 0) &&
                    std::ranges::all_of(points_then, [](const std::array<std::int32_t, 3>& p) {
                      return std::ranges::all_of(p, [](std::int32_t x) { return 0 <= x && x <= most; });
                    });
  if (!fits) {
    throw Error(
        "detector", "memory",
        std::to_string(points_then.size()) + " reference positions of near lists, or a position out of range",
        std::to_string(n) + " positions of [0, 2^30], as a detection saves them; none without near lists");
  }
  if (!coherent()) return;
  CompactGrid grid(settings.order, settings.sort);
  FixedPositions fixed_then = *fixed;
  if (!points_then.empty()) {
    fixed_then.set_points(points_then);
    grid.build_points(threads, lattice, fixed_then);
    fixed_then.put_in_order(threads, grid.entries());
  }
  cluster_query->recall(memory.coherence, threads, bodies, may_touch(), grid, fixed_then);
  skipped_grid = memory.skipped_grid;
  if (skipped_grid) std::get<CompactGrid>(points).skip_points(threads, lattice, *fixed);
}

DetectorMemory Detector::memory() const {
  const State& s = *state_;
  const auto* const grid = std::get_if<CompactGrid>(&s.points);
  std::vector<std::array<std::int32_t, 3>> reference_points;
  ListPlan::Numbers coherence = ListPlan().numbers();
  if (s.cluster_query != nullptr && !s.other_domain) {
    for (const simd::FixedPoint& p : s.cluster_query->listed_points())
      reference_points.push_back({p.x, p.y, p.z});
    coherence = s.cluster_query->plan().numbers();
  }
  return {.cell_size = s.cell_size.cell_size,
          .trials = s.cell_size.trials,
          .lower = s.lattice.domain().lower,
          .upper = s.lattice.domain().upper,
          .detections = s.step,
          .repairs = grid == nullptr || grid->adaptive_switch().repairing(),
          .counts = s.counts,
          .tet_states = s.waiting.tets,
          .triangle_states = s.waiting.triangles,
          .fraction = s.fraction,
          .reference_points = std::move(reference_points),
          .coherence = coherence,
          .skipped_grid = s.skipped_grid};
}

void Detector::recall(const DetectorMemory& memory, std::span<const Vec3> positions) {
  State& s = *state_;
  const Vec3 extent = memory.upper - memory.lower;
  const auto size = [](double x) { return x >= 0.0 && x <= 4.0 * largest_coordinate; };
  if (!(memory.cell_size > 0.0) || !std::isfinite(memory.cell_size) || memory.detections == 0 ||
      !is_finite(memory.lower) || !size(extent.x) || !size(extent.y) || !size(extent.z)) {
    throw Error("detector", "memory", "a domain or cell size out of range",
                "the values that a detector has saved");
  }
  s.cell_size.cell_size = memory.cell_size;
  s.cell_size.trials = memory.trials;
  s.lattice = Lattice({memory.lower, memory.upper}, memory.cell_size);
  s.step = memory.detections - 1;
  s.recall_budget(memory);
  s.skips_coherence = true;
  s.tables.now() = {};  // its contacts belong to other positions
  s.plane_cache = {};
  detect(positions, memory.fraction);
  s.skips_coherence = false;
  s.recall_coherence(memory);
  if (auto* const grid = std::get_if<CompactGrid>(&s.points))
    grid->adaptive_switch().set_repairing(memory.repairs);
  s.counts = memory.counts;
}

void Detector::State::hold() {
  held.active = true;
  held.has_lists = false;
  held.counts = counts;
  held.times = times;
  held.lattice = lattice;
  held.step = step;
  tables.hold();
  if (!budget) return;
  held.fraction = fraction;
  held.waiting = waiting;
  held.waiting_now = {cluster_query->queue().states(), crossings.clustered().queue().states()};
  held.late_bodies = budget->late_bodies();
}

/// Call before border edges are found while a table is held: swaps the held lists (border edges and
/// crossings) with free memory.
void Detector::State::keep_held_lists() {
  if (!held.active || held.has_lists) return;
  border_edges.swap_edges(held.border_edges);
  crossings.swap_crossings(held.crossings);
  held.has_lists = true;
}

void Detector::State::swap_back() {
  if (!held.active) return;
  if (held.has_lists) {
    border_edges.swap_edges(held.border_edges);
    crossings.swap_crossings(held.crossings);
  }
  counts = held.counts;
  times = held.times;
  const Box& domain = held.lattice.domain();
  other_domain = domain.lower != lattice.domain().lower || domain.upper != lattice.domain().upper ||
                 held.lattice.cell_size() != lattice.cell_size();
  lattice = held.lattice;
  step = held.step;
  tables.swap_back();
  held.active = false;
  if (!budget) return;
  fraction = held.fraction;
  waiting = held.waiting;
  cluster_query->queue().states() = held.waiting_now.tets;
  crossings.clustered().queue().states() = held.waiting_now.triangles;
  budget->set_late_bodies(held.late_bodies);
}

void Detector::State::release() {
  held.active = false;
  tables.release();
}

ContactTable& DetectorSteps::table(Detector& detector) {
  return detector.state_->tables.now();
}
const ContactTable& DetectorSteps::table(const Detector& detector) {
  return detector.state_->tables.now();
}
PairFilter DetectorSteps::may_touch(const Detector& detector) {
  return detector.state_->may_touch();
}
const SurfaceNormals* DetectorSteps::normals(const Detector& detector) {
  return detector.state_->settings.edge_contacts ? &detector.state_->depth.normals() : nullptr;
}
void DetectorSteps::hold(Detector& detector) {
  detector.state_->hold();
}
void DetectorSteps::swap_back(Detector& detector) {
  detector.state_->swap_back();
}
void DetectorSteps::release(Detector& detector) {
  detector.state_->release();
}

}  // namespace palpate

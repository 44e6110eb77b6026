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
#include "contact/list_plan.hpp"

namespace palpate {

void Detector::State::check_coherence(const DetectorMemory& memory) const {
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
}

DetectorMemory Detector::memory() const {
  const State& s = *state_;
  const Box& domain = s.frame.lattice().domain();
  DetectorMemory memory;
  memory.cell_size = s.frame.cell_size().cell_size;
  memory.trials = s.frame.cell_size().trials;
  memory.lower = domain.lower;
  memory.upper = domain.upper;
  memory.detections = s.frame.detections();
  memory.counts = s.counts;
  memory.coherence = ListPlan().numbers();
  s.points->save(s.frame, memory);
  if (s.budget) s.budget->save(memory);
  return memory;
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
  s.check_coherence(memory);
  if (s.budget) s.budget->recall(memory);
  s.frame.recall(memory.cell_size, memory.trials, {memory.lower, memory.upper}, memory.detections - 1);
  s.tables.now() = {};  // its contacts belong to other positions
  s.plane_cache = {};
  s.detect(positions, memory.fraction, true);
  s.points->recall(s.frame, memory);
  s.counts = memory.counts;
}

void Detector::State::hold() {
  held.active = true;
  held.has_lists = false;
  held.counts = counts;
  held.times = times;
  frame.hold();
  tables.hold();
  if (budget) budget->hold();
}

/// Call before border edges are found while a table is held: swaps the held lists (border edges and
/// crossings) with free memory.
void Detector::State::keep_held_lists() {
  if (!held.active || held.has_lists) return;
  border_edges.swap_edges(held.border_edges);
  crossings.swap(held.crossings);
  held.has_lists = true;
}

void Detector::State::swap_back() {
  if (!held.active) return;
  if (held.has_lists) {
    border_edges.swap_edges(held.border_edges);
    crossings.swap(held.crossings);
  }
  counts = held.counts;
  times = held.times;
  frame.swap_back();
  tables.swap_back();
  held.active = false;
  if (budget) budget->swap_back();
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
  return detector.state_->frame.may_touch();
}
void DetectorSteps::set_tied_points(Detector& detector, std::vector<std::array<Index, 2>> points) {
  detector.state_->frame.set_tied_points(std::move(points));
}
DetectedSurfaces DetectorSteps::surfaces(const Detector& detector) {
  const Detector::State& state = *detector.state_;
  if (!state.edge_contacts) return {};
  return {&state.depth.normals(), &state.border_edges, &state.crossings};
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

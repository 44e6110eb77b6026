#include "contact/frame.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include <palpate/error.hpp>

#include "grid/cell_size.hpp"

namespace palpate {
namespace {

/// The domain: the bounds with a margin, so that it is valid for many detections. Within it, points at rest
/// keep their cell index.
Box padded(const Box& bounds, double cell_size) {
  const Vec3 extent = bounds.upper - bounds.lower;
  const double margin = 2.0 * cell_size;
  const Vec3 pad{margin + 0.1 * extent.x, margin + 0.1 * extent.y, margin + 0.1 * extent.z};
  return {bounds.lower - pad, bounds.upper + pad};
}

/// Whether a domain is so much larger than the bounds that most of its cells are wasted.
bool too_large(const Box& domain, const Box& needed) {
  const Vec3 d = domain.upper - domain.lower;
  const Vec3 n = needed.upper - needed.lower;
  return d.x > 2.0 * n.x || d.y > 2.0 * n.y || d.z > 2.0 * n.z;
}

/// The flags of a setting; all 0 where it gives none.
std::vector<std::uint8_t> flags_of_bodies(std::vector<std::uint8_t> flags, const char* name,
                                          std::size_t bodies) {
  if (flags.empty()) flags.assign(bodies, 0);
  if (flags.size() != bodies) {
    throw Error("detection settings", name, std::to_string(flags.size()) + " flags",
                std::to_string(bodies) + ", one for each body");
  }
  return flags;
}

/// The pairs of bodies that a setting lists, sorted, with the lower body first in each.
/// \param bodies  number of bodies
std::vector<std::array<Index, 2>> sorted_pairs(std::vector<std::array<Index, 2>> pairs, Index bodies) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    auto& [a, b] = pairs[i];
    if (a > b) std::swap(a, b);
    if (a < 0 || b >= bodies || a == b) {
      throw Error("detection settings", "ignored_pairs[" + std::to_string(i) + "]",
                  "bodies " + std::to_string(a) + " and " + std::to_string(b),
                  "two different bodies in [0, " + std::to_string(bodies - 1) + "]");
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

int slots_of(const DetectionSettings& settings) {
  const std::optional<int> slots = settings.cells_per_primitive;
  if (slots && (*slots < 1 || *slots > CellSlots::most)) {
    throw Error("detection settings", "cells_per_primitive", std::to_string(*slots),
                "1 to 27, or none for exact");
  }
  return slots.value_or(0);
}

}  // namespace

Frame::Frame(const Bodies& bodies, const DetectionSettings& settings, std::vector<std::uint8_t> immovable,
             int threads)
    : bodies_(&bodies),
      threads_(threads),
      immovable_(flags_of_bodies(std::move(immovable), "immovable", bodies.bodies().size())),
      self_collision_(flags_of_bodies(settings.self_collision, "self_collision", bodies.bodies().size())),
      ignored_pairs_(sorted_pairs(settings.ignored_pairs, bodies.body_count())),
      slots_(slots_of(settings)),
      in_a_tet_(bodies.points_rest().size()) {
  check_cell_size(settings.cell_size);
  cell_size_.wanted = settings.cell_size;
  std::vector<std::uint8_t> marks(in_a_tet_.size());
  for (std::size_t p = 0; p < in_a_tet_.size(); ++p) {
    in_a_tet_[p] = bodies.point_tets()[static_cast<Index>(p)].empty() ? 0 : 1;
    marks[p] = at(immovable_, bodies.body_of_point()[p]);
  }
  if (works_on_clusters(settings)) fixed_.emplace(in_a_tet_, marks);
}

void Frame::set_tied_points(std::vector<std::array<Index, 2>> points) {
  tied_points_ = std::move(points);
  tied_bodies_.clear();
  for (const auto& [point, body] : tied_points_)
    tied_bodies_.push_back({at(bodies_->body_of_point(), point), body});
  tied_bodies_ = sorted_pairs(std::move(tied_bodies_), bodies_->body_count());
  tied_bodies_.erase(std::ranges::unique(tied_bodies_).begin(), tied_bodies_.end());
}

void Frame::place(std::span<const Vec3> positions, const Clusters* clusters) {
  positions_ = positions;
  // First try the lattice of the last detection.
  std::optional<Box> placed;
  const bool has_lattice = lattice_.cell_size() != 0.0;
  if (has_lattice && fixed() != nullptr) placed = fixed_->place(grid_threads(), lattice_, positions);
  const Box bounds = placed ? *placed : bounds_of(grid_threads(), positions, in_a_tet_, box_scratch_);
  if (cell_size_.cell_size == 0.0)
    cell_size_ = choose_cell_size(threads_, *bodies_, positions, in_a_tet_, cell_size_.wanted, clusters);
  const Box needed = padded(bounds, cell_size_.cell_size);
  const Box& domain = lattice_.domain();
  const bool fits = has_lattice && domain.contains(bounds.lower) && domain.contains(bounds.upper) &&
                    !too_large(domain, needed);
  if (!fits) lattice_ = Lattice(needed, cell_size_.cell_size);
  if (fixed() != nullptr && (!fits || !placed)) fixed_->place(grid_threads(), lattice_, positions);
  const bool other = std::exchange(is_swapped_, false);
  has_new_lattice_ = !fits || other;
}

void Frame::hold() {
  held_lattice_ = lattice_;
  held_detections_ = detections_;
}

void Frame::swap_back() {
  const Box& domain = lattice_.domain();
  const Box& held = held_lattice_.domain();
  is_swapped_ = held.lower != domain.lower || held.upper != domain.upper ||
                held_lattice_.cell_size() != lattice_.cell_size();
  lattice_ = held_lattice_;
  detections_ = held_detections_;
}

void Frame::recall(double cell_size, std::vector<CellSizeTrial> trials, const Box& domain,
                   std::uint64_t detections) {
  cell_size_.cell_size = cell_size;
  cell_size_.trials = std::move(trials);
  lattice_ = Lattice(domain, cell_size);
  detections_ = detections;
}

std::size_t MoverCount::count(const Frame& frame) {
  cell_of_point_.resize(frame.positions().size());
  const double moved = parallel::sum(frame.threads(), cell_of_point_.size(), scratch_, [&](std::size_t p) {
    const std::optional<Cell> cell = frame.cell_of(static_cast<Index>(p));
    if (!cell) return 0.0;
    const std::uint64_t index = frame.lattice().linear_index(*cell);
    const bool same = index == std::exchange(cell_of_point_[p], index);
    return same && !frame.has_new_lattice() ? 0.0 : 1.0;
  });
  return static_cast<std::size_t>(moved);
}

}  // namespace palpate

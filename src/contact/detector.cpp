#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/border_edges.hpp"
#include "contact/cluster_query.hpp"
#include "contact/contact_list.hpp"
#include "contact/crossings.hpp"
#include "contact/depth.hpp"
#include "contact/detection_budget.hpp"
#include "contact/points_in_tets.hpp"
#include "contact/remembered_planes.hpp"
#include "grid/brute.hpp"
#include "grid/cell_size.hpp"
#include "grid/cell_slots.hpp"
#include "grid/compact.hpp"
#include "grid/cuckoo.hpp"
#include "grid/fixed_positions.hpp"
#include "grid/hash.hpp"
#include "grid/uniform.hpp"
#include "number_text.hpp"
#include "stopwatch.hpp"

namespace palpate {
namespace {

using AnyStructure = std::variant<UniformGrid, CompactGrid, HashGrid, CuckooGrid, BruteForce>;

AnyStructure make_structure(Structure structure, Order order, Sort sort) {
  switch (structure) {
    case Structure::uniform:
      return UniformGrid{order};
    case Structure::compact:
      return CompactGrid{order, sort};
    case Structure::hash:
      return HashGrid{};
    case Structure::cuckoo:
      return CuckooGrid{order};
    case Structure::brute:
      return BruteForce{};
  }
  throw Error("detection settings", "structure", std::to_string(static_cast<int>(structure)),
              "a known structure");
}

std::optional<CuckooCounts> cuckoo_counts(const AnyStructure& structure) {
  const auto* const cuckoo = std::get_if<CuckooGrid>(&structure);
  return cuckoo == nullptr ? std::nullopt : std::optional(cuckoo->counts());
}

/// The domain grows beyond the bounds by this, so that it lasts for many frames and keeps the cell indices of
/// points that do not move.
Box padded(const Box& bounds, double cell_size) {
  const Vec3 extent = bounds.upper - bounds.lower;
  const double margin = 2.0 * cell_size;
  const Vec3 pad{margin + 0.1 * extent.x, margin + 0.1 * extent.y, margin + 0.1 * extent.z};
  return {bounds.lower - pad, bounds.upper + pad};
}

/// The pairs of two of `bodies` bodies that a setting lists, ascending, the lower body first in each.
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

/// Whether a domain has become so much larger than the bounds that its cells are wasted.
bool too_large(const Box& domain, const Box& needed) {
  const Vec3 d = domain.upper - domain.lower;
  const Vec3 n = needed.upper - needed.lower;
  return d.x > 2.0 * n.x || d.y > 2.0 * n.y || d.z > 2.0 * n.z;
}

}  // namespace

struct Detector::State {
  State(const Bodies& b, const DetectionSettings& s, std::vector<std::uint8_t> i, int n)
      : bodies(b), settings(s), immovable(std::move(i)), threads(n), border_edges(b), depth(b) {
    if (bodies.body_count() == 0) throw Error("detector", "bodies", "none", "at least one");
    if (immovable.empty()) immovable.assign(bodies.bodies().size(), 0);
    if (immovable.size() != bodies.bodies().size()) {
      throw Error("detection settings", "immovable", std::to_string(immovable.size()) + " flags",
                  std::to_string(bodies.bodies().size()) + ", one for each body");
    }
    std::vector<std::uint8_t>& self = settings.self_collision;
    if (self.empty()) self.assign(bodies.bodies().size(), 0);
    if (self.size() != bodies.bodies().size()) {
      throw Error("detection settings", "self_collision", std::to_string(self.size()) + " flags",
                  std::to_string(bodies.bodies().size()) + ", one for each body");
    }
    settings.ignored_pairs = sorted_pairs(std::move(settings.ignored_pairs), bodies.body_count());
    if (settings.cells_per_primitive &&
        (*settings.cells_per_primitive < 1 || *settings.cells_per_primitive > CellSlots::most)) {
      throw Error("detection settings", "cells_per_primitive", std::to_string(*settings.cells_per_primitive),
                  "1 to 27, or none for exact");
    }
    check_cell_size(settings.cell_size);
    in_a_tet.resize(bodies.points_rest().size());
    for (std::size_t p = 0; p < in_a_tet.size(); ++p) {
      in_a_tet[p] = bodies.point_tets()[static_cast<Index>(p)].empty() ? 0 : 1;
    }
    points = make_structure(settings.structure, settings.order, settings.sort);
    edges = make_structure(settings.structure, settings.order, settings.sort);
    if (settings.budget) budget = std::make_unique<DetectionBudget>(settings, bodies.bodies().size());
    // The slots of approximate mode are those of single tets.
    if (settings.structure == Structure::compact && !settings.cells_per_primitive) {
      cluster_query = std::make_unique<ClusterQuery>(bodies);
      crossings.use_clusters(bodies);
      fixed = std::make_unique<FixedPositions>(in_a_tet, marks_of_immovable());
    }
  }
  /// Whether this detection asks with clusters of tets.
  [[nodiscard]] bool clustered() const {
    return cluster_query != nullptr && FixedPositions::represents(lattice);
  }
  /// Whether it gains from earlier frames where it can.
  [[nodiscard]] bool coherent() const { return settings.coherence && !budget && clustered(); }
  [[nodiscard]] PairFilter may_touch() const {
    return {immovable, settings.self_collision, settings.ignored_pairs};
  }
  [[nodiscard]] std::vector<std::uint8_t> marks_of_immovable() const {
    std::vector<std::uint8_t> marks(in_a_tet.size());
    for (std::size_t p = 0; p < marks.size(); ++p) marks[p] = at(immovable, bodies.body_of_point()[p]);
    return marks;
  }

  void update_domain(std::span<const Vec3> positions);
  void count_movers(std::span<const Vec3> positions);
  void update_grid(std::span<const Vec3> positions);
  void find_points_in_tets(std::span<const Vec3> positions, const CellSlots& slots);
  /// What this detection may spend; none: it is not limited.
  [[nodiscard]] Allowance* limit() { return budget && clustered() ? budget->allowance() : nullptr; }
  void begin_budget(double share);
  /// With a budget in time.
  [[nodiscard]] bool remembers_planes() const { return budget && settings.budget->milliseconds; }
  void choose_planes(std::span<const Vec3> positions);
  void limit_crossings();
  void end_budget();
  void recall_budget(const DetectorMemory& memory);
  void recall_coherence(const DetectorMemory& memory);

  const Bodies& bodies;
  DetectionSettings settings;
  std::vector<std::uint8_t> immovable;  ///< per body
  std::vector<std::uint8_t> in_a_tet;   ///< per point; unreferenced points take no part
  parallel::Threads threads;
  CellSizeChoice cell_size;  ///< made at the first detection
  std::uint64_t step = 0;    ///< detections so far

  Lattice lattice;
  bool new_domain = true;
  std::vector<Box> box_scratch;
  std::vector<std::uint64_t> cell_of_point;  ///< cell index of each point at the last detection
  std::vector<double> mover_scratch;

  AnyStructure points;
  AnyStructure edges;
  PointsInTets points_in_tets;
  std::unique_ptr<ClusterQuery> cluster_query;  ///< for the compact grid
  std::unique_ptr<FixedPositions> fixed;        ///< with cluster_query
  bool skips_coherence = false;                 ///< for this detection
  bool skipped_grid = false;                    ///< the last detection did without
  std::unique_ptr<DetectionBudget> budget;      ///< none: without limit
  Allowance* crossings_limit = nullptr;         ///< of the budget; none: without limit
  std::vector<std::uint8_t> tet_notes;          ///< of the budget, before the last detection
  std::vector<std::uint8_t> triangle_notes;
  double share = 1.0;
  RememberedPlanes planes;  ///< of the budget
  QueryTally points_tally;
  ContactList contacts;
  BorderEdges border_edges;
  CrossingQuery crossings;
  DepthEstimate depth;

  DetectionCounts counts;
  DetectionTimes times;
};

void Detector::State::update_domain(std::span<const Vec3> positions) {
  // In the hope that last frame's domain will do.
  std::optional<Box> placed;
  if (lattice.cell_size() != 0.0 && clustered()) placed = fixed->place(threads, lattice, positions);
  const Box bounds = placed ? *placed : bounds_of(threads, positions, in_a_tet, box_scratch);
  if (cell_size.cell_size == 0.0) {
    cell_size = choose_cell_size(threads, bodies, positions, in_a_tet, settings.cell_size,
                                 cluster_query ? &cluster_query->clusters() : nullptr);
  }
  const Box needed = padded(bounds, cell_size.cell_size);
  const Box& domain = lattice.domain();
  new_domain = lattice.cell_size() == 0.0 || !domain.contains(bounds.lower) ||
               !domain.contains(bounds.upper) || too_large(domain, needed);
  if (new_domain) lattice = Lattice(needed, cell_size.cell_size);
  if (clustered() && (new_domain || !placed)) fixed->place(threads, lattice, positions);
}

void Detector::State::count_movers(std::span<const Vec3> positions) {
  cell_of_point.resize(positions.size());
  const double moved = parallel::sum(threads, positions.size(), mover_scratch, [&](std::size_t p) {
    if (in_a_tet[p] == 0) return 0.0;
    const std::uint64_t index = lattice.linear_index(lattice.cell_of(positions[p]));
    const bool same = index == std::exchange(cell_of_point[p], index);
    return same && !new_domain ? 0.0 : 1.0;
  });
  counts.movers = static_cast<std::size_t>(moved);
}

void Detector::State::update_grid(std::span<const Vec3> positions) {
  update_domain(positions);
  if (clustered()) {
    auto& grid = std::get<CompactGrid>(points);
    skipped_grid =
        coherent() && !skips_coherence && !cluster_query->begin_frame(threads, bodies, *fixed, new_domain);
    if (skipped_grid) {
      grid.skip_points(threads, lattice, *fixed);
    } else {
      counts.sort = grid.build_points(threads, lattice, *fixed);
      fixed->put_in_order(threads, grid.entries());
    }
    if (grid.tells_cells_apart()) {
      counts.movers = new_domain ? grid.entries().size() : grid.movers();
    } else {
      count_movers(positions);
    }
    return;
  }
  count_movers(positions);
  std::visit(
      [&](auto& structure) {
        const auto cell_of = [&](Index p) {
          return at(in_a_tet, p) == 0 ? std::nullopt : std::optional(lattice.cell_of(at(positions, p)));
        };
        if constexpr (requires { structure.build_points(threads, lattice, positions.size(), cell_of); }) {
          counts.sort = structure.build_points(threads, lattice, positions.size(), cell_of);
        } else {
          structure.build(threads, lattice, positions.size(), [&](Index p, auto&& emit) {
            if (const std::optional<Cell> cell = cell_of(p)) emit((*cell)[0], (*cell)[1], (*cell)[2]);
          });
        }
      },
      points);
}

DetectionTimes& DetectionTimes::operator+=(const DetectionTimes& other) {
  grid += other.grid;
  contacts += other.contacts;
  border_edges += other.border_edges;
  crossings += other.crossings;
  depth += other.depth;
  return *this;
}

void Detector::State::find_points_in_tets(std::span<const Vec3> positions, const CellSlots& slots) {
  const PairFilter may_touch = this->may_touch();
  if (clustered()) {
    const Stopwatch watch;
    if (Allowance* const allowance = limit()) {
      cluster_query->find_within(*allowance, budget->region(), threads, bodies, positions, may_touch,
                                 std::get<CompactGrid>(points), *fixed);
    } else {
      cluster_query->find(threads, bodies, positions, may_touch, std::get<CompactGrid>(points), *fixed);
    }
    if (budget) budget->end_points(watch.seconds());
    contacts.assign(threads, bodies, positions, cluster_query->found());
    points_tally = cluster_query->tally();
    return;
  }
  std::visit(
      [&](auto& structure) {
        points_in_tets.find(threads, bodies, positions, may_touch, lattice, structure, slots);
      },
      points);
  contacts.assign(threads, bodies, positions, points_in_tets.found());
  points_tally = points_in_tets.tally();
}

Detector::Detector(const Bodies& bodies, const DetectionSettings& settings,
                   std::vector<std::uint8_t> immovable, int threads)
    : state_(std::make_unique<State>(bodies, settings, std::move(immovable), threads)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

void Detector::State::begin_budget(double new_share) {
  if (!budget) return;
  share = new_share;
  tet_notes = cluster_query->queue().notes();
  triangle_notes = crossings.clustered().queue().notes();
  budget->begin(share);
}

/// Contacts that there is no time for take the way out that they had.
void Detector::State::choose_planes(std::span<const Vec3> positions) {
  planes.choose_none();
  if (!remembers_planes()) return;
  const std::size_t anew =
      limit() == nullptr ? contacts.contacts().size() : budget->contacts_anew(contacts.contacts().size());
  planes.choose(threads, bodies, positions, contacts.contacts(), anew, budget->region());
}

void Detector::State::limit_crossings() {
  if (!budget) return;
  crossings_limit = limit() == nullptr ? nullptr : budget->begin_crossings();
  crossings.clustered().limit(crossings_limit, budget->region());
}

void Detector::State::recall_budget(const DetectorMemory& memory) {
  if (!budget) return;
  std::vector<std::uint8_t>& tets = cluster_query->queue().notes();
  std::vector<std::uint8_t>& triangles = crossings.clustered().queue().notes();
  if (memory.tet_notes.size() != tets.size() || memory.triangle_notes.size() != triangles.size() ||
      !(memory.share > 0.0) || !(memory.share <= 1.0)) {
    throw Error("detector", "memory", "a budget that is not that of these bodies", "that of a detector");
  }
  tets = memory.tet_notes;
  triangles = memory.triangle_notes;
}

void Detector::State::recall_coherence(const DetectorMemory& memory) {
  const std::size_t n = bodies.points_rest().size();
  const auto& points_then = memory.noted_points;
  constexpr std::int32_t most = 1 << 30;  // as large as fixed positions become
  const bool fits = ListPlan::allows(memory.coherence) &&
                    points_then.size() == (memory.coherence[0] != 0 ? n : 0) &&
                    std::ranges::all_of(points_then, [](const std::array<std::int32_t, 3>& p) {
                      return std::ranges::all_of(p, [](std::int32_t x) { return 0 <= x && x <= most; });
                    });
  if (!fits) throw Error("detector", "memory", "noted points that no detection leaves", "that of a detector");
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

void Detector::State::end_budget() {
  if (!budget) return;
  budget->end(times, planes.spared(), limit() == nullptr ? nullptr : &cluster_query->queue(),
              crossings_limit == nullptr ? nullptr : &crossings.clustered().queue(), counts);
}

void Detector::detect(std::span<const Vec3> positions, double share) {
  State& s = *state_;
  if (positions.size() != s.bodies.points_rest().size()) {
    throw Error("positions", "", std::to_string(positions.size()) + " points",
                std::to_string(s.bodies.points_rest().size()) + ", as the bodies have");
  }
  Stopwatch watch;
  s.begin_budget(share);
  s.update_grid(positions);
  s.times.grid = watch.lap();
  const CellSlots slots(s.settings.cells_per_primitive.value_or(0), s.step);

  s.find_points_in_tets(positions, slots);
  s.choose_planes(positions);
  s.times.contacts = watch.lap();

  s.border_edges.find(s.threads, s.bodies, positions, s.contacts, s.planes.sources());
  s.times.border_edges = watch.lap();

  s.limit_crossings();
  std::visit(
      [&](auto& structure) {
        s.crossings.find(s.threads, s.bodies, positions, s.contacts.contacts(), s.border_edges.edges(),
                         s.lattice, structure, slots, s.clustered() ? s.fixed.get() : nullptr);
      },
      s.edges);
  s.times.crossings = watch.lap();

  static_cast<DepthCounts&>(s.counts) =
      s.depth.compute(s.threads, s.bodies, positions, s.contacts, s.border_edges, s.crossings, s.planes,
                      s.budget ? s.budget->refining() : Deadline{});
  if (s.remembers_planes()) {
    s.planes.remember(s.threads, s.bodies, positions, s.contacts.contacts(),
                      [&](std::size_t c) { return s.depth.outcome(c); });
  }
  s.times.depth = watch.lap();

  s.counts.contacts = s.contacts.contacts().size();
  s.counts.border_edges = s.border_edges.edges().size();
  s.counts.crossings = s.crossings.crossings().size();
  QueryTally tally = s.points_tally;
  tally += s.crossings.tally();
  s.counts.candidates = tally.candidates;
  s.counts.approximated_primitives = tally.approximated_primitives;
  s.counts.dropped_cells = tally.dropped_cells;
  s.counts.folded_pairs = tally.folded_pairs;
  ++s.step;
  s.counts.cells = s.lattice.cell_count();
  s.counts.cell_size = s.lattice.cell_size();
  s.counts.cell_doublings = s.lattice.doublings();
  s.counts.cuckoo_points = cuckoo_counts(s.points);
  s.counts.cuckoo_edges = cuckoo_counts(s.edges);
  s.end_budget();
}

const Contacts& Detector::contacts() const {
  return state_->contacts.contacts();
}
Contacts Detector::take_contacts() {
  return std::exchange(state_->contacts.contacts(), Contacts{});
}
std::span<const BorderEdge> Detector::border_edges() const {
  return state_->border_edges.edges();
}
std::span<const Crossing> Detector::crossings() const {
  return state_->crossings.crossings();
}
const DetectionCounts& Detector::counts() const {
  return state_->counts;
}
const DetectionTimes& Detector::times() const {
  return state_->times;
}

CellDomain Detector::cell_domain() const {
  const Lattice& lattice = state_->lattice;
  return {lattice.domain().lower, lattice.size(), lattice.cell_size()};
}
std::span<const std::uint8_t> Detector::late_bodies() const {
  return state_->budget ? std::span<const std::uint8_t>(state_->budget->late_bodies())
                        : std::span<const std::uint8_t>{};
}
double Detector::least_seconds() const {
  return state_->budget ? state_->budget->least().high() : 0.0;
}
const CellSizeChoice& Detector::cell_size_choice() const {
  return state_->cell_size;
}
DetectorMemory Detector::memory() const {
  const State& s = *state_;
  const auto* const grid = std::get_if<CompactGrid>(&s.points);
  std::vector<std::array<std::int32_t, 3>> noted_points;
  ListPlan::Numbers coherence = ListPlan().numbers();
  if (s.cluster_query != nullptr) {
    for (const simd::FixedPoint& p : s.cluster_query->listed_points())
      noted_points.push_back({p.x, p.y, p.z});
    coherence = s.cluster_query->plan().numbers();
  }
  return {.cell_size = s.cell_size.cell_size,
          .trials = s.cell_size.trials,
          .lower = s.lattice.domain().lower,
          .upper = s.lattice.domain().upper,
          .detections = s.step,
          .repairs = grid == nullptr || grid->adaptive_switch().repairing(),
          .counts = s.counts,
          .tet_notes = s.tet_notes,
          .triangle_notes = s.triangle_notes,
          .share = s.share,
          .noted_points = std::move(noted_points),
          .coherence = coherence,
          .skipped_grid = s.skipped_grid};
}

void Detector::recall(const DetectorMemory& memory, std::span<const Vec3> positions) {
  State& s = *state_;
  const Vec3 extent = memory.upper - memory.lower;
  const auto size = [](double x) { return x >= 0.0 && x <= 4.0 * largest_coordinate; };
  if (!(memory.cell_size > 0.0) || !std::isfinite(memory.cell_size) || memory.detections == 0 ||
      !is_finite(memory.lower) || !size(extent.x) || !size(extent.y) || !size(extent.z)) {
    throw Error("detector", "memory", "a domain or cell size that no detection leaves", "that of a detector");
  }
  s.cell_size.cell_size = memory.cell_size;
  s.cell_size.trials = memory.trials;
  s.lattice = Lattice({memory.lower, memory.upper}, memory.cell_size);
  s.step = memory.detections - 1;
  s.recall_budget(memory);
  s.skips_coherence = true;
  s.planes = {};  // of another time
  detect(positions, memory.share);
  s.skips_coherence = false;
  s.recall_coherence(memory);
  if (auto* const grid = std::get_if<CompactGrid>(&s.points))
    grid->adaptive_switch().set_repairing(memory.repairs);
  s.counts = memory.counts;
}

std::size_t Detector::structure_bytes() const {
  const auto bytes = [](const auto& structure) { return structure.bytes(); };
  const std::size_t beside = state_->crossings.bytes() + (state_->fixed ? state_->fixed->bytes() : 0) +
                             (state_->cluster_query ? state_->cluster_query->lists().bytes() : 0);
  return std::visit(bytes, state_->points) + std::visit(bytes, state_->edges) + beside;
}

}  // namespace palpate

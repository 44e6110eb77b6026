#include <algorithm>
#include <utility>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/detector_state.hpp"
#include "number_text.hpp"
#include "stopwatch.hpp"

namespace palpate {
namespace {

std::optional<CuckooCounts> cuckoo_counts(const AnyStructure& structure) {
  const auto* const cuckoo = std::get_if<CuckooGrid>(&structure);
  return cuckoo == nullptr ? std::nullopt : std::optional(cuckoo->counts());
}

/// The domain: the bounds with a margin, so that it is valid for many frames. Within it, points at rest keep
/// their cell index.
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

}  // namespace

void Detector::State::update_domain(std::span<const Vec3> positions) {
  // First try the domain of the last frame.
  std::optional<Box> placed;
  if (lattice.cell_size() != 0.0 && clustered()) placed = fixed->place(grid_threads(), lattice, positions);
  const Box bounds = placed ? *placed : bounds_of(grid_threads(), positions, in_a_tet, box_scratch);
  if (cell_size.cell_size == 0.0) {
    cell_size = choose_cell_size(threads, bodies, positions, in_a_tet, settings.cell_size,
                                 cluster_query ? &cluster_query->clusters() : nullptr);
  }
  const Box needed = padded(bounds, cell_size.cell_size);
  const Box& domain = lattice.domain();
  const bool fits = lattice.cell_size() != 0.0 && domain.contains(bounds.lower) &&
                    domain.contains(bounds.upper) && !too_large(domain, needed);
  if (!fits) lattice = Lattice(needed, cell_size.cell_size);
  if (clustered() && (!fits || !placed)) fixed->place(grid_threads(), lattice, positions);
  const bool other = std::exchange(other_domain, false);
  new_domain = !fits || other;
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
      grid.skip_points(grid_threads(), lattice, *fixed);
    } else {
      counts.sort = grid.build_points(grid_threads(), lattice, *fixed);
      fixed->put_in_order(grid_threads(), grid.entries());
    }
    if (grid.distinguishes_cells()) {
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
    tables.begin();
    tables.now().assign(threads, bodies, positions, cluster_query->found(), &tables.last());
    points_tally = cluster_query->tally();
    return;
  }
  std::visit(
      [&](auto& structure) {
        points_in_tets.find(threads, bodies, positions, may_touch, lattice, structure, slots);
      },
      points);
  tables.begin();
  tables.now().assign(threads, bodies, positions, points_in_tets.found(), &tables.last());
  points_tally = points_in_tets.tally();
}

void Detector::State::begin_budget(double fraction_of_budget) {
  if (!budget) return;
  fraction = fraction_of_budget;
  waiting = {cluster_query->queue().states(), crossings.clustered().queue().states()};
  budget->begin(fraction);
}

/// Contacts for which there is no time use their cached plane.
void Detector::State::choose_planes(std::span<const Vec3> positions) {
  plane_cache.choose_none();
  if (!caches_planes()) return;
  const std::size_t contacts = tables.now().size();
  const std::size_t most = limit() == nullptr ? contacts : budget->recomputed_contacts_limit(contacts);
  plane_cache.choose(threads, bodies, positions, tables.now(), tables.last(), most, budget->region());
}

void Detector::State::find_edge_contacts(std::span<const Vec3> positions) {
  if (edge_contacts)
    edge_contacts->find(threads, bodies, positions, may_touch(), tables.now(), tables.now().edges());
}

void Detector::State::estimate_depths(std::span<const Vec3> positions) {
  static_cast<DepthCounts&>(counts) =
      depth.compute(threads, bodies, positions, tables.now(), border_edges, crossings, plane_cache,
                    budget ? budget->refining() : Deadline{});
  if (!caches_planes()) return;
  plane_cache.update(threads, bodies, positions, tables.now(), tables.last(),
                     [&](std::size_t c) { return depth.outcome(c); });
}

void Detector::State::finish_counts() {
  counts.contacts = tables.now().size();
  counts.edge_contacts = tables.now().edges().size();
  counts.border_edges = border_edges.edges().size();
  counts.crossings = crossings.crossings().size();
  QueryTally tally = points_tally;
  tally += crossings.tally();
  counts.candidates = tally.candidates;
  counts.approximated_primitives = tally.approximated_primitives;
  counts.dropped_cells = tally.dropped_cells;
  counts.folded_pairs = tally.folded_pairs;
  counts.cells = lattice.cell_count();
  counts.cell_size = lattice.cell_size();
  counts.cell_doublings = lattice.doublings();
  counts.cuckoo_points = cuckoo_counts(points);
  counts.cuckoo_edges = cuckoo_counts(edges);
}

void Detector::State::limit_crossings() {
  if (!budget) return;
  crossings_limit = limit() == nullptr ? nullptr : budget->begin_crossings();
  crossings.clustered().limit(crossings_limit, budget->region());
}

void Detector::State::end_budget() {
  if (!budget) return;
  budget->end(times, plane_cache.spared(), limit() == nullptr ? nullptr : &cluster_query->queue(),
              crossings_limit == nullptr ? nullptr : &crossings.clustered().queue(), counts);
}

void Detector::detect(std::span<const Vec3> positions, double fraction) {
  State& s = *state_;
  if (positions.size() != s.bodies.points_rest().size()) {
    throw Error("positions", "", std::to_string(positions.size()) + " points",
                std::to_string(s.bodies.points_rest().size()) + ", as the bodies have");
  }
  Stopwatch watch;
  s.begin_budget(fraction);
  s.update_grid(positions);
  s.times.grid = watch.lap();

  const CellSlots slots(s.settings.cells_per_primitive.value_or(0), s.step);
  s.find_points_in_tets(positions, slots);
  s.choose_planes(positions);
  s.times.contacts = watch.lap();

  const ContactTable& table = s.tables.now();
  s.keep_held_lists();
  s.border_edges.find(s.threads, s.bodies, positions, table, s.plane_cache.sources());
  s.times.border_edges = watch.lap();

  s.limit_crossings();
  std::visit(
      [&](auto& structure) {
        s.crossings.find(s.threads, s.bodies, positions, table.contacts(), s.border_edges.edges(), s.lattice,
                         structure, slots, s.clustered() ? s.fixed.get() : nullptr);
      },
      s.edges);
  s.find_edge_contacts(positions);
  s.times.crossings = watch.lap();

  s.estimate_depths(positions);
  s.times.depth = watch.lap();

  s.finish_counts();
  ++s.step;
  s.end_budget();
}

const Contacts& Detector::contacts() const {
  return state_->tables.now().contacts();
}
Contacts Detector::take_contacts() {
  return state_->tables.now().take_contacts();
}
const EdgeContacts& Detector::edge_contacts() const {
  return state_->tables.now().edges();
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
  return state_->budget ? state_->budget->shortest_detection().high() : 0.0;
}
const CellSizeChoice& Detector::cell_size_choice() const {
  return state_->cell_size;
}
std::size_t Detector::structure_bytes() const {
  const auto bytes = [](const auto& structure) { return structure.bytes(); };
  const std::size_t beside = state_->crossings.bytes() + (state_->fixed ? state_->fixed->bytes() : 0) +
                             (state_->cluster_query ? state_->cluster_query->lists().bytes() : 0);
  return std::visit(bytes, state_->points) + std::visit(bytes, state_->edges) + beside;
}

}  // namespace palpate

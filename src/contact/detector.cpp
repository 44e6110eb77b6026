#include <algorithm>
#include <functional>
#include <string>
#include <utility>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/detector_state.hpp"
#include "stopwatch.hpp"

namespace palpate {
namespace {

const Bodies& checked(const Bodies& bodies) {
  if (bodies.body_count() == 0) throw Error("detector", "bodies", "none", "at least one");
  return bodies;
}

}  // namespace

Detector::State::State(const Bodies& b, const DetectionSettings& settings,
                       std::vector<std::uint8_t> immovable, int threads)
    : bodies(checked(b)),
      frame(b, settings, std::move(immovable), threads),
      points(make_point_query(b, settings)),
      edges(make_crossing_query(b, settings)),
      border_edges(b),
      depth(b) {
  if (settings.budget) {
    DetectionBudget::check(settings);
    budget =
        std::make_unique<DetectionBudget>(settings, b.bodies().size(), *points->queue(), *edges->queue());
  }
  const bool meets_itself = std::ranges::any_of(frame.may_touch().self_collision, std::identity{});
  if (b.body_count() == 1 && !meets_itself) return;
  if (settings.edge_contacts) {
    edge_contacts = std::make_unique<EdgeContactQuery>(b, settings.coherence);
  } else {
    unseen = std::make_unique<UnseenPairs>(b, settings.coherence);
  }
}

void Detector::State::update(std::span<const Vec3> positions, bool alone) {
  frame.place(positions, points->clusters());
  const PointQuery::Update updated = points->update(frame, alone);
  if (updated.sort) counts.sort = updated.sort;
  counts.movers = updated.movers;
}

void Detector::State::find_contacts() {
  const Stopwatch watch;
  points->find(frame, budget ? budget->points_limit() : std::nullopt);
  if (budget) budget->end_points(watch.seconds());
  tables.begin();
  tables.now().assign(frame.threads(), bodies, frame.positions(), points->found(), &tables.last());
  plane_cache.choose_none();
  if (!caches_planes()) return;
  // Contacts for which there is no time use their cached plane.
  plane_cache.choose(frame.threads(), bodies, frame.positions(), tables.now(), tables.last(),
                     budget->recomputed_contacts_limit(tables.now().size()), budget->region());
}

void Detector::State::find_crossings() {
  const BorderEdgeView border{tables.now().contacts(), border_edges.edges()};
  edges->find(frame, border, budget ? budget->begin_crossings() : std::nullopt);
  crossings.set(frame.threads(), bodies, frame.positions(), border, edges->found());
  const Deadline deadline = budget ? budget->edges_deadline() : Deadline{};
  // Bodies that pass through each other do so for many detections.
  constexpr std::uint64_t detections_between = 8;
  if (unseen && frame.detections() % detections_between == 0)
    counts.unseen_pairs = unseen->count(frame, tables.now(), deadline);
  if (!edge_contacts) return;
  edge_contacts->find(frame.threads(), bodies, frame.positions(), frame.may_touch(), tables.now(),
                      tables.now().edges(), deadline);
  if (budget) budget->end_edges(edge_contacts->work());
}

void Detector::State::find_depths() {
  static_cast<DepthCounts&>(counts) =
      depth.compute(frame.threads(), bodies, frame.positions(), tables.now(), border_edges, crossings,
                    plane_cache, budget ? budget->refining() : Deadline{});
  if (!caches_planes()) return;
  plane_cache.update(frame.threads(), bodies, frame.positions(), tables.now(), tables.last(),
                     [&](std::size_t c) { return depth.outcome(c); });
}

void Detector::State::finish_counts() {
  counts.contacts = tables.now().size();
  counts.edge_contacts = tables.now().edges().size();
  counts.border_edges = border_edges.edges().size();
  counts.crossings = crossings.all().size();
  QueryTally tally = points->tally();
  tally += edges->tally();
  counts.candidates = tally.candidates;
  counts.approximated_primitives = tally.approximated_primitives;
  counts.dropped_cells = tally.dropped_cells;
  counts.folded_pairs = tally.folded_pairs;
  counts.cells = frame.lattice().cell_count();
  counts.cell_size = frame.lattice().cell_size();
  counts.cell_doublings = frame.lattice().doublings();
  counts.cuckoo_points = points->cuckoo();
  counts.cuckoo_edges = edges->cuckoo();
}

void Detector::State::detect(std::span<const Vec3> positions, double fraction, bool alone) {
  if (positions.size() != bodies.points_rest().size()) {
    throw Error("positions", "", std::to_string(positions.size()) + " points",
                std::to_string(bodies.points_rest().size()) + ", as the bodies have");
  }
  Stopwatch watch;
  if (budget) budget->begin(fraction);
  update(positions, alone);
  times.grid = watch.lap();

  find_contacts();
  times.contacts = watch.lap();

  keep_held_lists();
  border_edges.find(frame.threads(), bodies, positions, tables.now(), plane_cache.sources());
  times.border_edges = watch.lap();

  find_crossings();
  times.crossings = watch.lap();

  find_depths();
  times.depth = watch.lap();

  finish_counts();
  frame.end();
  if (budget) budget->end(times, plane_cache.spared(), counts);
}

DetectionTimes& DetectionTimes::operator+=(const DetectionTimes& other) {
  grid += other.grid;
  contacts += other.contacts;
  border_edges += other.border_edges;
  crossings += other.crossings;
  depth += other.depth;
  return *this;
}

Detector::Detector(const Bodies& bodies, const DetectionSettings& settings,
                   std::vector<std::uint8_t> immovable, int threads)
    : state_(std::make_unique<State>(bodies, settings, std::move(immovable), threads)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

void Detector::detect(std::span<const Vec3> positions, double fraction) {
  state_->detect(positions, fraction);
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
  return state_->crossings.all();
}
const DetectionCounts& Detector::counts() const {
  return state_->counts;
}
const DetectionTimes& Detector::times() const {
  return state_->times;
}

CellDomain Detector::cell_domain() const {
  const Lattice& lattice = state_->frame.lattice();
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
  return state_->frame.cell_size();
}
std::size_t Detector::structure_bytes() const {
  return state_->frame.bytes() + state_->points->bytes() + state_->edges->bytes();
}

}  // namespace palpate

#include "sim/swept_response.hpp"

#include <algorithm>
#include <cmath>

#include "contact/swept_sides.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Tolerance of a touch, relative to the mean edge length of all bodies.
constexpr double tolerance_of_edge = 1e-6;
/// Depth, relative to the local thickness of the body, up to which contacts of the start of the step
/// are separated for the search: their nearest exit is on the side from which they came.
constexpr double most_separated = 0.25;
/// Length of the displacement that separates them, relative to the depth: the direction may be oblique to the
/// surface.
constexpr double depths_apart = 1.5;
/// Relative motion in a step, over the smaller local thickness, up to which a pair is left out: deep contacts
/// at rest would be stopped for moving a little.
constexpr double least_motion_of_pair = 0.1;
/// Upper bound of the first stiffness, relative to that of other contacts.
constexpr double most_first_stiffness = 100.0;
/// How often a pair is stopped in a step at most. Each stop is ten times as stiff as the one before; more
/// would exceed double precision.
constexpr std::ptrdiff_t most_stops = 6;
/// Cosine of the angle up to which a stop repeats an earlier one. The primitives may rotate from one solve to
/// the next; then the earlier law did not fail, but acts in another direction.
constexpr double same_direction = 0.9;

double mean_edge(const Bodies& bodies) {
  return bodies.edges().empty() ? 0.0 : mesh_statistics(bodies, bodies.points_rest()).edge_length.mean;
}

}  // namespace

SweptResponse::SweptResponse(const Bodies& bodies)
    : bodies_(bodies),
      query_(bodies),
      exits_(bodies, query_.thickness()),
      tolerance_(tolerance_of_edge * mean_edge(bodies)) {}

std::span<const StopOfPassing> SweptResponse::find(const parallel::Threads& threads,
                                                   const PredictedStep& step, const PairFilter& filter,
                                                   const ContactResponse& response,
                                                   std::span<const fem::Coupling> contacts) {
  stops_.clear();
  nearest_.clear();
  now_.clear();
  left_ = 0;
  if (query_.may_pass(threads, step.start, step.end, filter, settings())) {
    const std::span<const Vec3> from = start_.separated(step.start);
    end_.clear();
    list_shifts(step.contacts, {.deepest = deepest_point, .of_thinner = true}, end_);
    const std::span<const Vec3> to = end_.separated(step.end);
    const PredictedStep path{from, step.end, step.velocities, step.time_step, step.contacts, step.complete};
    exits_.set_end(step.contacts);
    for (SweptContact contact : query_.find(threads, step.start, from, to, filter, settings())) {
      contact.direction = entry_direction(contact, {bodies_, from, to});
      if (contact.direction != Vec3{}) add(contact, path, step.start, response);
    }
  }
  add_sinking(step, response, contacts);
  const auto before = static_cast<std::ptrdiff_t>(stopped_.size());
  make_room(stopped_, stopped_.size() + now_.size());
  stopped_.insert(stopped_.end(), now_.begin(), now_.end());
  const auto by_key = [](const Stopped& a, const Stopped& b) { return a.key < b.key; };
  std::stable_sort(stopped_.begin() + before, stopped_.end(), by_key);
  std::inplace_merge(stopped_.begin(), stopped_.begin() + before, stopped_.end(), by_key);
  return stops_;
}

void SweptResponse::count(const parallel::Threads& threads, const PredictedStep& step,
                          const PairFilter& filter, double least_motion) {
  query_.count(threads, step.start, step.end, filter, {tolerance_, least_motion});
}

SweptResponse::Key SweptResponse::key_of(const SweptContact& contact) const {
  const bool of_edges = contact.kind == SweptKind::edge_edge;
  return {contact.kind, contact.first,
          of_edges ? contact.second : bodies_.body_of(at(bodies_.triangles(), contact.second))};
}

/// The first point belongs to the first body, the second point to the other.
fem::Coupling SweptResponse::coupling_of(const SweptContact& contact) const {
  fem::Coupling coupling;
  const auto& w = contact.weights;
  if (contact.kind == SweptKind::edge_edge) {
    const Edge& a = at(bodies_.edges(), contact.first);
    const Edge& b = at(bodies_.edges(), contact.second);
    coupling.points = {a[0], a[1], b[0], b[1], -1};
    coupling.coefficients = {1.0 - w[0], w[0], w[1] - 1.0, -w[1], 0.0};
    return coupling;
  }
  const Triangle& triangle = at(bodies_.triangles(), contact.second);
  const Tet& tet = at(bodies_.tets(), at(bodies_.triangle_tets(), contact.second));
  coupling.points = {contact.first, tet[0], tet[1], tet[2], tet[3]};
  coupling.coefficients[0] = 1.0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      if (tet[i] == triangle[c]) coupling.coefficients[1 + i] = -w[c];
  }
  return coupling;
}

/// Least local thickness of the triangles that touch, m.
double SweptResponse::thickness(const SweptContact& contact) const {
  const std::vector<double>& of_triangle = query_.thickness().of_triangle;
  if (contact.kind == SweptKind::point_triangle) return at(of_triangle, contact.second);
  return std::min(query_.thickness().of_edge(bodies_, contact.first),
                  query_.thickness().of_edge(bodies_, contact.second));
}

/// \param step   whose paths begin where bodies do not overlap
/// \param start  positions at the start of the step
void SweptResponse::add(const SweptContact& contact, const PredictedStep& step, std::span<const Vec3> start,
                        const ContactResponse& response) {
  const fem::Coupling coupling = coupling_of(contact);
  const double thick = thickness(contact);
  // A thin part of a cluster must not make the others fast.
  const bool of_point = contact.kind == SweptKind::point_triangle;
  const double thinner = of_point ? std::min(thick, at(query_.thickness().of_point, contact.first)) : thick;
  const Vec3 motion = fem::relative(coupling, step.end) - fem::relative(coupling, start);
  if (length(motion) <= least_motion_of_pair * thinner) return;
  const double margin = margin_of_thickness * thick;
  const Vec3 relative = fem::relative(coupling, step.end);
  // What has gone through a body that rotates may be before the plane of entry again.
  Vec3 direction = direction_at_end(contact, {bodies_, step.start, step.end});
  if (dot(direction, relative) >= 0.0) direction = contact.direction;
  const double end = dot(direction, relative);
  const double before = overlap_before(contact, coupling, start);
  if (!(end < 0.0) || exits_.has_exit(contact, {direction, -end, before, thick})) return;
  // What is near already may come nearer: kept at the margin by each step, it would never rest on a contact.
  const double apart = std::max(0.0, dot(direction, fem::relative(coupling, start)));
  const double nearest = std::min(margin - before, 0.5 * apart);
  add(key_of(contact),
      {coupling, direction, nearest, margin - end, margin, contact.kind == SweptKind::edge_edge}, step,
      response);
}

void SweptResponse::begin_step(std::span<const Vec3> positions, const ContactTable& contacts) {
  stopped_.clear();
  stopped_pairs_.clear();
  acting_.clear();
  start_.clear();
  // With room for edges that may come to a pile of points in contact, so that only the first steps allocate.
  start_ends_.clear();
  make_room(start_ends_, 2 * contacts.edges().size() + contacts.size() / 4);
  list_ends(positions, contacts.edges());
  list_shifts(contacts, {.deepest = most_separated, .of_thinner = false}, start_);
  exits_.begin_step(contacts);
}

/// Shifts of points and edges in shallow contact out of the body in which they are. The search finds only
/// what touches after the start: a point that leaves a body and enters again through the same triangle would
/// be found when it leaves, and edges of bodies that overlap already have no outside to come from. And what
/// a body only slides over, a little deep, would be entered through its side.
void SweptResponse::list_shifts(const ContactTable& contacts, const Shallow& shallow,
                                Separation& list) const {
  const Contacts& points = contacts.contacts();
  const EdgeContacts& edges = contacts.edges();
  make_room(list.shifts, points.size() + 2 * edges.size());
  const LocalThickness& thickness = query_.thickness();
  const auto shift_of = [&](double depth, const Vec3& direction, double thick, double own) {
    if (depth > shallow.deepest * (shallow.of_thinner ? std::min(thick, own) : thick)) return Vec3{};
    return (depths_apart * depth + margin_of_thickness * thick) * direction;
  };
  for (std::size_t c = 0; c < points.size(); ++c) {
    const Vec3 by = shift_of(points.depth[c], points.direction[c], thickness.of_contact(bodies_, points, c),
                             at(thickness.of_point, points.point[c]));
    if (by != Vec3{}) list.shifts.push_back({points.point[c], by});
  }
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const Vec3 by = shift_of(edges.depth[c], edges.direction[c], thickness.of_contact(edges, c),
                             thickness.of_edge(bodies_, edges.edge[c]));
    if (by == Vec3{}) continue;
    for (const Index point : at(bodies_.edges(), edges.edge[c])) list.shifts.push_back({point, by});
  }
}

void SweptResponse::Separation::clear() {
  shifts.clear();
  places.clear();
}

/// Positions at which contacts that are shallow do not overlap.
std::span<const Vec3> SweptResponse::Separation::separated(std::span<const Vec3> positions) {
  if (shifts.empty()) return positions;
  if (places.empty()) {
    make_room(places, positions.size());
    places.assign(positions.begin(), positions.end());
    for (const Shift& shift : shifts) at(places, shift.point) += shift.by;
  }
  return places;
}

/// How deep a pair was already at the start of the step, m: only if its points were shifted out of a contact.
double SweptResponse::overlap_before(const SweptContact& contact, const fem::Coupling& coupling,
                                     std::span<const Vec3> start) const {
  if (start_.places.empty()) return 0.0;
  const double distance = dot(contact.direction, fem::relative(coupling, start));
  const double shifted = dot(contact.direction, fem::relative(coupling, start_.places));
  return std::clamp(-distance, 0.0, std::max(shifted - distance, 0.0));
}

/// How often a pair was stopped in this step in about this direction.
std::ptrdiff_t SweptResponse::times_stopped(const Key& key, const Vec3& direction) const {
  const auto stops = std::ranges::equal_range(stopped_, key, {}, &Stopped::key);
  return std::ranges::count_if(
      stops, [&](const Stopped& stop) { return dot(stop.direction, direction) > same_direction; });
}

/// Adds a law whose stiffness stops the mass of its points within the margin; times ten for each time that
/// the pair was stopped before in this step.
void SweptResponse::add(const Key& key, const Passing& passing, const PredictedStep& step,
                        const ContactResponse& response) {
  const std::ptrdiff_t before = times_stopped(key, passing.direction);
  const double mass = response.reduced_mass(passing.coupling);
  if (mass == 0.0) return;  // all its points are prescribed
  if (before >= most_stops) {
    ++left_;
    return;
  }
  const auto& points = passing.coupling.points;
  const double usual = response.stiffness(at(bodies_.body_of_point(), points[0]),
                                          at(bodies_.body_of_point(), points[passing.of_edge ? 2 : 1]));
  const double force = mass * passing.beyond / (step.time_step * step.time_step);
  double stiffness = std::clamp(force / passing.margin, usual, most_first_stiffness * usual);
  for (std::ptrdiff_t time = 0; time < before; ++time) stiffness *= 10.0;
  make_room(stops_, stops_.size() + 1);
  make_room(now_, now_.size() + 1);
  now_.push_back({key, passing.direction});
  StopOfPassing& stop = stops_.emplace_back();
  stop.law.stiffness = stiffness;
  stop.law.direction = passing.direction;
  stop.of_edge = passing.of_edge;
  stop.coupling.points = passing.coupling.points;
  stop.coupling.coefficients = passing.coupling.coefficients;
  stop.law.depth = -gap_of(stop, passing.nearest, step);
  make_room(nearest_, stops_.size());
  nearest_.push_back(passing.nearest);
}

/// The gap with which a law is exact at the predicted positions: a body that rotates ends elsewhere than its
/// velocity leads to.
double SweptResponse::gap_of(const StopOfPassing& stop, double nearest, const PredictedStep& step) {
  return dot(stop.law.direction, fem::relative(stop.coupling, step.end) -
                                     step.time_step * fem::relative(stop.coupling, step.velocities)) -
         nearest;
}

PairOfBodies SweptResponse::bodies_of(const StopOfPassing& stop) const {
  const auto& points = stop.coupling.points;
  return pair_of(at(bodies_.body_of_point(), points[0]),
                 at(bodies_.body_of_point(), points[stop.of_edge ? 2 : 1]));
}

bool SweptResponse::stops_new_pair() const {
  return std::ranges::any_of(stops_, [&](const StopOfPassing& stop) {
    return !std::ranges::binary_search(stopped_pairs_, bodies_of(stop));
  });
}

void SweptResponse::stop(const PredictedStep& step, ContactResponse& response,
                         std::vector<fem::Coupling>& couplings) {
  for (const Acting& one : acting_) response.set_gap(one.law, gap_of(one.stop, one.nearest, step));
  make_room(acting_, acting_.size() + stops_.size());
  for (std::size_t i = 0; i < stops_.size(); ++i)
    acting_.push_back({response.laws().size() + i, stops_[i], nearest_[i]});
  for (const StopOfPassing& stop : stops_) {
    const PairOfBodies pair = bodies_of(stop);
    const auto place = std::ranges::lower_bound(stopped_pairs_, pair);
    if (place == stopped_pairs_.end() || *place != pair) stopped_pairs_.insert(place, pair);
  }
  response.add_stops(stops_, couplings);
}

}  // namespace palpate

#include "sim/edge_response.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/triangle.hpp"
#include "room.hpp"
#include "sim/response.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 64;
// Cosines of the angle between surface normal and contact direction. Above the first the surface is a face;
// below the second it is a side.
constexpr double faces_along = 0.95;
constexpr double faces_aside = 0.6;
/// Stiffness at an end, relative to that of a contact.
constexpr double part_of_an_end = 0.5;
/// An end acts only if the product of its weights is at least this. Smaller ones have no effect on the bodies
/// but cost a row of the solver. Most edges of uneven faces in contact have smaller ones.
constexpr double least_weight = 0.05;

double beyond_least(double weight) {
  return std::max(0.0, (weight - least_weight) / (1.0 - least_weight));
}

/// The point where an edge meets a triangle.
struct Meeting {
  Index triangle;
  double parameter;               ///< on the edge
  std::array<double, 3> weights;  ///< in the triangle
  double side;                    ///< 0 to 1: 1 if the triangle is a side as seen along the direction
  double steepness;               ///< of the edge over the triangle: sine of the angle between them
};

Meeting meeting(const EdgeResponse::Frame& frame, const Edge& edge, Index triangle, double parameter,
                const Vec3& direction) {
  const Triangle& corners = at(frame.bodies.triangles(), triangle);
  const std::array<Vec3, 3> t = corners_of(frame.positions, corners);
  const Vec3& a = at(frame.positions, edge[0]);
  const Vec3 x = a + parameter * (at(frame.positions, edge[1]) - a);
  Meeting found{triangle, parameter, weights_in(t, area_vector(t), x), 0.0, 0.0};
  const Vec3 normal = frame.normals.at_point_now(frame.positions, triangle, x);
  found.steepness = std::abs(dot(normalized(at(frame.positions, edge[1]) - a), normal));
  const double cosine = dot(normal, direction);
  found.side = std::clamp((faces_along - cosine) / (faces_along - faces_aside), 0.0, 1.0);
  return found;
}

/// Fraction of an edge of this depth that the contact of a point supports: 1 if it has half the force or
/// more.
double held_by(const EdgeResponse::Frame& frame, Index contact, double depth) {
  constexpr double enough = 0.5;
  if (contact < 0) return 0.0;
  const double force = at(frame.scales, contact) * at(frame.table.contacts().depth, contact);
  return std::min(1.0, force / (enough * depth));
}

/// held_by() for the corners of a triangle and their neighbours, interpolated by barycentric weights.
double held_near(const EdgeResponse::Frame& frame, const Meeting& meeting, Index body, double depth) {
  double held = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Index corner = at(frame.bodies.triangles(), meeting.triangle)[i];
    double most = held_by(frame, frame.table.find(corner, body), depth);
    for (const Index edge : frame.bodies.point_edges()[corner]) {
      const Index neighbor = frame.bodies.other_end(edge, corner);
      most = std::max(most, held_by(frame, frame.table.find(neighbor, body), depth));
    }
    held += meeting.weights[i] * most;
  }
  return held;
}

/// Factor of the force of an edge by the angle of its own body there: zero if the surface is flat or concave,
/// one for convex edges of a few degrees or more. A body that comes through a face has points or convex edges
/// in it.
double sharpness(const EdgeResponse::Frame& frame, Index edge) {
  constexpr double sharp = 0.25;        // sine
  constexpr double surely_sharp = 0.9;  // cosine
  const auto& [first, second] = at(frame.bodies.edge_triangles(), edge);
  if (second < 0) return 1.0;
  const Triangle& other = at(frame.bodies.triangles(), second);
  const Vec3 normal = normalized(area_vector(frame.positions, at(frame.bodies.triangles(), first)));
  const Vec3 other_normal = normalized(area_vector(frame.positions, other));
  const Edge& ends = at(frame.bodies.edges(), edge);
  const Index third = *std::ranges::find_if(other, [&](Index p) { return p != ends[0] && p != ends[1]; });
  if (dot(normal, at(frame.positions, third) - at(frame.positions, ends[0])) >= 0.0) return 0.0;
  if (dot(normal, other_normal) < surely_sharp) return 1.0;
  return std::min(1.0, length(cross(normal, other_normal)) / sharp);
}

/// 0 to 1: 1 for an edge with a crease of 60 degrees or more, 0 below 30 degrees.
double crease(const EdgeResponse::Frame& frame, Index edge) {
  constexpr double none = 0.866;  // cosines
  constexpr double surely = 0.5;
  const auto& [first, second] = at(frame.bodies.edge_triangles(), edge);
  if (second < 0) return 1.0;
  const auto normal = [&](Index t) {
    return normalized(area_vector(frame.positions, at(frame.bodies.triangles(), t)));
  };
  return std::clamp((none - dot(normal(first), normal(second))) / (none - surely), 0.0, 1.0);
}

/// Whether an edge is at the seam of its body with another one: there is no crease.
bool borders_flush_face(const EdgeResponse::Frame& frame, Index edge) {
  return std::ranges::any_of(at(frame.bodies.edge_triangles(), edge),
                             [&](Index t) { return t >= 0 && frame.flush.covers(t); });
}

/// Whether an edge leaves, or its exit leads, through a face that lies flush on another body.
bool is_at_seam(const EdgeResponse::Frame& frame, Index body, const RimEdge& found) {
  if (found.triangle >= 0 && frame.flush.covers(found.triangle)) return true;
  if (borders_flush_face(frame, found.edge)) return true;
  if (found.triangle >= 0) return found.beyond >= 0 && frame.flush.covers(found.beyond);
  const auto& [first, second] = at(frame.bodies.edges(), found.edge);
  const Vec3& a = at(frame.positions, first);
  const Vec3 along = at(frame.positions, second) - a;
  return std::ranges::any_of(std::array{0.0, 0.5, 1.0}, [&](double part) {
    return frame.flush.leads_through(frame.bodies, frame.positions, body, a + part * along, found.direction,
                                     found.depth);
  });
}

EdgeEnd end_of(Index edge, Index body, Index number, double stiffness, double depth, const Vec3& direction) {
  EdgeEnd end{.edge = edge, .body = body, .end = number, .law = {}};
  end.law.stiffness = stiffness;
  end.law.depth = depth;
  end.law.direction = direction;
  return end;
}

void add_at_triangle(const EdgeResponse::Frame& frame, const Edge& edge, const Meeting& meeting, EdgeEnd end,
                     std::vector<EdgeResponse::Row>& rows) {
  const Triangle& t = at(frame.bodies.triangles(), meeting.triangle);
  const auto& [w0, w1, w2] = meeting.weights;
  end.points = {edge[0], edge[1], t[0], t[1], t[2]};
  end.coefficients = {1.0 - meeting.parameter, meeting.parameter, -w0, -w1, -w2};
  rows.push_back({.end = end, .depth = end.law.depth});
}

}  // namespace

fem::Coupling EdgeEnd::coupling() const {
  fem::Coupling coupling;
  coupling.points = points;
  coupling.coefficients = coefficients;
  return coupling;
}

void EdgeResponse::add_edge_contact(const Frame& frame, std::size_t contact, Index number,
                                    std::vector<Row>& rows) const {
  const EdgeContacts& contacts = frame.table.edges();
  const Edge& edge = at(frame.bodies.edges(), contacts.edge[contact]);
  const Index body = contacts.body[contact];
  const double depth = contacts.depth[contact];
  if (!(depth > 0.0)) return;
  const double whole = length(at(frame.positions, edge[1]) - at(frame.positions, edge[0]));
  const auto& [enters, leaves] = contacts.parameters[contact];
  const auto part = [&](double parameters) {
    return std::min(1.0, parameters * whole / frame.rules.rim_reach(body));
  };
  const Index own = frame.bodies.body_of(edge);
  double most = part(leaves - enters);
  if (most > least_weight) most *= sharpness(frame, contacts.edge[contact]);
  if (most <= least_weight) return;
  const auto& [entry, exit] = contacts.triangles[contact];
  if (frame.flush.covers(entry) || frame.flush.covers(exit)) return;
  if (borders_flush_face(frame, contacts.edge[contact])) return;
  std::array<Meeting, 2> meetings;
  for (std::size_t end = 0; end < 2; ++end) {
    meetings[end] = meeting(frame, edge, contacts.triangles[contact][end], contacts.parameters[contact][end],
                            contacts.direction[contact]);
  }
  // Depths are measured from the planes through which the ends enter.
  const double outside = part(enters * meetings[0].steepness) * part((1.0 - leaves) * meetings[1].steepness);
  // As soon as an end is inside, the factor of an edge at a rim applies.
  const double lack = support_.lack(own, body);
  const double beside = lack + (1.0 - lack) * outside;
  const double whole_stiffness = stiffness_of_an_end(frame, own, body);
  for (std::size_t end = 0; end < 2; ++end) {
    const Meeting& here = meetings[end];
    double weight = most * (here.side * beside + (1.0 - here.side) * outside);
    if (weight > least_weight) weight *= 1.0 - held_near(frame, here, own, depth);
    if (weight <= least_weight) continue;
    add_at_triangle(frame, edge, here,
                    end_of(contacts.edge[contact], body, 2 * number + static_cast<Index>(end),
                           beyond_least(weight) * whole_stiffness, depth, contacts.direction[contact]),
                    rows);
  }
}

double EdgeResponse::stiffness_of_an_end(const Frame& frame, Index own, Index body) const {
  return part_of_an_end * support_.softness(own, body) * frame.rules.stiffness(own, body);
}

/// Adds the edges of a contact at a rim. An edge between two such contacts is added for the lower point.
void EdgeResponse::add_rim_edges(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                                 std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[contact];
  const Index body = contacts.body[contact];
  const RimEdgeSearch::Frame places{frame.bodies, frame.positions, frame.table, frame.rules.rim_reach(body)};
  for (const Index edge : frame.bodies.point_edges()[point]) {
    if (at(frame.bodies.edge_triangles(), edge)[0] < 0) continue;
    const Index other = frame.bodies.other_end(edge, point);
    const Index there = frame.table.find(other, body);
    const bool at_rim = frame.scales[contact] < 1.0;
    if (there >= 0 && (other < point || !at_rim || at(frame.scales, there) >= 1.0)) continue;
    RimEdge found;
    if (search.find(places, static_cast<Index>(contact), edge, found)) add_rim_edge(frame, body, found, rows);
  }
}

void EdgeResponse::add_rim_edge(const Frame& frame, Index body, const RimEdge& found,
                                std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Edge& edge = at(frame.bodies.edges(), found.edge);
  const Index own = frame.bodies.body_of(edge);
  const double whole = length(at(frame.positions, edge[1]) - at(frame.positions, edge[0]));
  double inside = 1.0;
  if (found.triangle >= 0) inside = found.contacts[0] >= 0 ? found.parameter : 1.0 - found.parameter;
  const double length_part = std::min(1.0, inside * whole / frame.rules.rim_reach(body));
  double held = 0.0;
  for (const Index c : found.contacts) held = std::max(held, held_by(frame, c, found.depth));
  double most = (1.0 - held) * support_.lack(own, body) * length_part;
  const bool at_rim =
      std::ranges::any_of(found.contacts, [&](Index c) { return c >= 0 && at(frame.scales, c) < 1.0; });
  if (!at_rim) most *= crease(frame, found.edge);
  if (most <= least_weight || is_at_seam(frame, body, found)) return;
  const double whole_stiffness = stiffness_of_an_end(frame, own, body);
  for (std::size_t i = 0; i < 2; ++i) {
    EdgeEnd end = end_of(found.edge, body, static_cast<Index>(i), beyond_least(most) * whole_stiffness,
                         found.depth, found.direction);
    const Index c = found.contacts[i];
    if (c < 0) {
      const Meeting here = meeting(frame, edge, found.triangle, found.parameter, found.direction);
      end.law.stiffness = beyond_least(most * here.side) * whole_stiffness;
      if (end.law.stiffness > 0.0) add_at_triangle(frame, edge, here, end, rows);
      continue;
    }
    const fem::Coupling coupling = coupling_of(
        at(contacts.point, c), at(frame.bodies.tets(), at(contacts.tet, c)), at(contacts.weights, c));
    end.points = coupling.points;
    end.coefficients = coupling.coefficients;
    end.of_edge = false;
    rows.push_back({.end = end, .depth = end.law.depth});
  }
}

/// Makes all rows, sorted by key, without slip and damping.
void EdgeResponse::list(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  const EdgeContacts& edges = frame.table.edges();
  support_.measure(frame.bodies, frame.positions, contacts, frame.scales);
  const ContactStates& states = frame.table.states();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (states.soft[c] == 0) continue;
    const Index own = at(frame.bodies.body_of_point(), contacts.point[c]);
    const double usual = frame.scales[c] * frame.rules.stiffness(own, contacts.body[c]);
    support_.soften(own, contacts.body[c], states.stiffness[c] / usual);
  }
  // Reserves room for contacts that begin and end, so that only the first steps allocate.
  for (auto* list : {&now_, &before_}) make_room(*list, frame.table.size());
  make_room(rows_, frame.table.size());
  make_room(numbers_, frame.table.size());
  lists_.make_room_in_all(parallel::chunk_count(frame.table.size() + edges.size(), grain), 2 * grain);
  resize_with_room(numbers_, edges.size());
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const bool same = c > 0 && edges.edge[c] == edges.edge[c - 1] && edges.body[c] == edges.body[c - 1];
    numbers_[c] = same ? numbers_[c - 1] + 1 : 0;
  }
  lists_.fill(frame.threads, edges.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t c = begin; c < end; ++c) add_edge_contact(frame, c, numbers_[c], rows);
              });
  lists_.join(frame.threads, rows_);
  unsupported_.clear();
  make_room(unsupported_, frame.table.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index own = at(frame.bodies.body_of_point(), contacts.point[c]);
    if (support_.lack(own, contacts.body[c]) > 0.0) unsupported_.push_back(static_cast<Index>(c));
  }
  const std::size_t chunks = parallel::chunk_count(unsupported_.size(), grain);
  if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
  lists_.fill(frame.threads, unsupported_.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t i = begin; i < end; ++i) {
                  const auto c = static_cast<std::size_t>(unsupported_[i]);
                  add_rim_edges(frame, c, searches_[begin / grain], rows);
                }
              });
  lists_.append(frame.threads, rows_, chunks);
  std::ranges::sort(rows_, {}, [](const Row& row) { return row.end.key(); });
}

std::span<const EdgeResponse::Row> EdgeResponse::begin(const Frame& frame) {
  now_.swap(before_);
  list(frame);
  resize_with_room(now_, rows_.size());
  parallel::for_each(frame.threads, rows_.size(), grain, [&](std::size_t i) {
    EdgeEnd& end = rows_[i].end;
    const fem::Coupling coupling = end.coupling();
    end.velocity = fem::relative(coupling, frame.velocities);
    const auto last = std::ranges::lower_bound(before_, end.key(), {}, &EdgeEnd::key);
    if (last != before_.end() && last->key() == end.key()) {
      if (last->lost == 0)
        end.law.slip = frame.rules.bounded_slip(last->law.slip + frame.since * end.velocity, end.law);
      const Index own = at(frame.bodies.body_of_point(), end.points[0]);
      end.chatter_damping =
          frame.rules.chatter_damping({.force = (last->law.stiffness * last->law.depth) * last->law.direction,
                                       .direction = last->law.direction,
                                       .velocity = last->velocity,
                                       .stiffness = last->law.stiffness,
                                       .damping = last->chatter_damping,
                                       .comes_back = last->lost > 0},
                                      (end.law.stiffness * end.law.depth) * end.law.direction, end.velocity,
                                      frame.rules.stiffness(own, end.body));
    }
    end.law.damping = frame.rules.damping(coupling, end.law.stiffness) + end.chatter_damping;
    end.acts = true;
    now_[i] = end;
  });
  return rows_;
}

std::span<const EdgeResponse::Row> EdgeResponse::near(const Frame& frame) {
  rows_.clear();
  make_room(rows_, before_.size());
  const auto present = static_cast<std::ptrdiff_t>(now_.size());
  make_room(now_, now_.size() + before_.size());
  for (const EdgeEnd& last : before_) {
    const auto here = std::span(now_).first(static_cast<std::size_t>(present));
    if (last.lost >= ContactTable::longest_absence ||
        std::ranges::binary_search(here, last.key(), {}, &EdgeEnd::key))
      continue;
    EdgeEnd& state = now_.emplace_back(last);
    ++state.lost;
    state.acts = false;
    if (!last.acts) continue;
    EdgeEnd end = last;
    end.law.damping = 0.0;
    end.law.slip = {};
    const fem::Coupling coupling = end.coupling();
    const Vec3 apart = fem::relative(coupling, frame.positions);
    const Vec3& direction = end.law.direction;
    const double depth = end.law.depth - dot(apart, direction);
    const Vec3 slid = apart - dot(apart, direction) * direction;
    const double speed = length(fem::relative(coupling, frame.velocities));
    state.acts = depth <= 0.0 && -depth <= frame.time_step * speed + frame.fall &&
                 length(slid) <= frame.rules.rim_reach(last.body);
    if (state.acts) rows_.push_back({.end = end, .depth = depth});
  }
  std::ranges::sort(now_, {}, &EdgeEnd::key);
  return rows_;
}

bool EdgeResponse::acts(const EdgeEnd& end) const {
  const auto place = std::ranges::lower_bound(now_, end.key(), {}, &EdgeEnd::key);
  return place != now_.end() && place->key() == end.key() && place->acts;
}

std::span<const EdgeResponse::Row> EdgeResponse::meet(const Frame& frame) {
  list(frame);
  std::erase_if(rows_, [&](const Row& row) { return acts(row.end); });
  for (auto& [end, depth, force] : rows_) {
    end.acts = true;
    // Depth before the step, on the straight line of the motion. Not above zero, since the end was outside.
    end.velocity = fem::relative(end.coupling(), frame.velocities);
    depth = std::min(depth + frame.time_step * dot(end.velocity, end.law.direction), 0.0);
    fem::ContactLaw law = end.law;
    law.depth = depth;
    force = fem::contact_force(law, {.coefficient = 0.0, .time_step = frame.time_step}, end.velocity).normal;
  }
  std::erase_if(rows_, [](const Row& row) { return row.force == 0.0; });
  return rows_;
}

void EdgeResponse::take() {
  make_room(now_, now_.size() + rows_.size());
  const auto known = static_cast<std::ptrdiff_t>(now_.size());
  for (const auto& [end, depth, force] : rows_) {
    const auto here = std::span(now_).first(static_cast<std::size_t>(known));
    const auto gone = std::ranges::lower_bound(here, end.key(), {}, &EdgeEnd::key);
    if (gone == here.end() || gone->key() != end.key()) {
      now_.push_back(end);
      continue;
    }
    const std::int32_t lost = gone->lost;
    const double damping = gone->chatter_damping;
    *gone = end;
    gone->lost = lost;
    gone->chatter_damping = damping;
  }
  std::ranges::sort(now_, {}, &EdgeEnd::key);
}

}  // namespace palpate

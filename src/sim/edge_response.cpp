#include "sim/edge_response.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/vector.hpp"
#include "room.hpp"
#include "sim/response.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 64;
// Cosines of the surface's normal with the direction between which it becomes a side.
constexpr double faces_along = 0.75;
constexpr double faces_aside = 0.25;
/// Of the stiffness of a contact.
constexpr double part_of_an_end = 0.5;

/// Where an edge meets a triangle.
struct Meeting {
  Index triangle;
  double parameter;               ///< on the edge
  std::array<double, 3> weights;  ///< in the triangle
  double side;                    ///< how far the triangle is a side of the direction, 0 to 1
};

Meeting meeting(const EdgeResponse::Frame& frame, const Edge& edge, Index triangle, double parameter,
                const Vec3& direction) {
  const Triangle& corners = at(frame.bodies.triangles(), triangle);
  const std::array<Vec3, 3> t{at(frame.positions, corners[0]), at(frame.positions, corners[1]),
                              at(frame.positions, corners[2])};
  const Vec3 normal = cross(t[1] - t[0], t[2] - t[0]);
  const Vec3& a = at(frame.positions, edge[0]);
  const Vec3 x = a + parameter * (at(frame.positions, edge[1]) - a);
  Meeting found{triangle, parameter, {1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, 0.0};
  std::array<double, 3> w{};
  double sum = 0.0;
  for (std::size_t i = 0; i < 3; ++i)
    sum += w[i] = std::max(0.0, dot(cross(t[(i + 1) % 3] - x, t[(i + 2) % 3] - x), normal));
  if (sum > 0.0) found.weights = {w[0] / sum, w[1] / sum, w[2] / sum};
  const double cosine = dot(normalized(normal), direction);
  found.side = std::clamp((faces_along - cosine) / (faces_along - faces_aside), 0.0, 1.0);
  return found;
}

/// Part of an edge this deep that the contact of a point holds: all, where it has half the force.
double held_by(const EdgeResponse::Frame& frame, Index contact, double depth) {
  constexpr double enough = 0.5;
  if (contact < 0) return 0.0;
  const double force = at(frame.scales, contact) * at(frame.table.contacts().depth, contact);
  return std::min(1.0, force / (enough * depth));
}

/// The same for the corners of a triangle in contact with a body, and their neighbours.
double held_near(const EdgeResponse::Frame& frame, Index triangle, Index body, double depth) {
  double most = 0.0;
  for (const Index corner : at(frame.bodies.triangles(), triangle)) {
    most = std::max(most, held_by(frame, frame.table.find(corner, body), depth));
    for (const Index edge : frame.bodies.point_edges()[corner]) {
      const Index neighbor = frame.bodies.other_end(edge, corner);
      most = std::max(most, held_by(frame, frame.table.find(neighbor, body), depth));
    }
  }
  return most;
}

EdgeResponse::Row row_of(const EdgeEnd& state, double stiffness, double depth, const Vec3& direction) {
  return {.law = {.stiffness = stiffness, .damping = 0.0, .depth = depth, .slip = {}, .direction = direction},
          .coupling = {},
          .state = state};
}

void add_at_triangle(const EdgeResponse::Frame& frame, const Edge& edge, const Meeting& at_end,
                     EdgeResponse::Row row, std::vector<EdgeResponse::Row>& rows) {
  const Triangle& t = at(frame.bodies.triangles(), at_end.triangle);
  const auto& [w0, w1, w2] = at_end.weights;
  row.coupling.points = {edge[0], edge[1], t[0], t[1], t[2]};
  row.coupling.coefficients = {1.0 - at_end.parameter, at_end.parameter, -w0, -w1, -w2};
  if (row.law.stiffness > 0.0) rows.push_back(row);
}

}  // namespace

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
  const double full = part_of_an_end * part(leaves - enters) * frame.rules.stiffness(own, body);
  const double outside = part(enters) * part(1.0 - leaves);
  // An edge at a rim acts that much, once an end is inside.
  const double lack = support_.lack(own, body);
  const double beside = lack + (1.0 - lack) * outside;
  for (std::size_t end = 0; end < 2; ++end) {
    const Meeting here = meeting(frame, edge, contacts.triangles[contact][end],
                                 contacts.parameters[contact][end], contacts.direction[contact]);
    const double needed = 1.0 - held_near(frame, here.triangle, own, depth);
    const double weight = needed * (here.side * beside + (1.0 - here.side) * outside);
    add_at_triangle(
        frame, edge, here,
        row_of({.edge = contacts.edge[contact], .body = body, .end = 2 * number + static_cast<Index>(end)},
               weight * full, depth, contacts.direction[contact]),
        rows);
  }
}

/// Edges of a contact at a rim; those that join two of them go with the lower point.
void EdgeResponse::add_rim_edges(const Frame& frame, std::size_t contact, RimEdgeSearch& search,
                                 std::vector<Row>& rows) const {
  const Contacts& contacts = frame.table.contacts();
  const Index point = contacts.point[contact];
  const Index body = contacts.body[contact];
  if (at(frame.bodies.body_of_point(), point) == body) return;
  const RimEdgeSearch::Frame places{frame.bodies,    sides_,      triangle_of_face_,
                                    frame.positions, frame.table, frame.rules.rim_reach(body)};
  for (const Index edge : frame.bodies.point_edges()[point]) {
    if (!sides_.is_on_surface(edge)) continue;
    const Index other = frame.bodies.other_end(edge, point);
    const Index there = frame.table.find(other, body);
    if (there >= 0 && (other < point || at(frame.scales, there) >= 1.0)) continue;
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
  const double full =
      part_of_an_end * support_.lack(own, body) * length_part * frame.rules.stiffness(own, body);
  double held = 0.0;
  for (const Index c : found.contacts) held = std::max(held, held_by(frame, c, found.depth));
  for (std::size_t end = 0; end < 2; ++end) {
    const EdgeEnd state{.edge = found.edge, .body = body, .end = static_cast<Index>(end)};
    const Index c = found.contacts[end];
    if (c >= 0) {
      Row row = row_of(state, (1.0 - held) * full, found.depth, found.direction);
      row.coupling = coupling_of(contacts.point[static_cast<std::size_t>(c)],
                                 at(frame.bodies.tets(), at(contacts.tet, c)), at(contacts.weights, c));
      row.state.of_edge = false;
      if (row.law.stiffness > 0.0) rows.push_back(row);
      continue;
    }
    const Meeting here = meeting(frame, edge, found.triangle, found.parameter, found.direction);
    add_at_triangle(frame, edge, here,
                    row_of(state, (1.0 - held) * here.side * full, found.depth, found.direction), rows);
  }
}

/// All rows, sorted by key, without slip and damping.
void EdgeResponse::list(const Frame& frame) {
  const Contacts& contacts = frame.table.contacts();
  const EdgeContacts& edges = frame.table.edges();
  support_.measure(frame.bodies, frame.positions, contacts, frame.scales);
  resize_with_room(numbers_, edges.size());
  for (std::size_t c = 0; c < edges.size(); ++c) {
    const bool same = c > 0 && edges.edge[c] == edges.edge[c - 1] && edges.body[c] == edges.body[c - 1];
    numbers_[c] = same ? numbers_[c - 1] + 1 : 0;
  }
  lists_.fill(frame.threads, edges.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t c = begin; c < end; ++c) add_edge_contact(frame, c, numbers_[c], rows);
              });
  lists_.join(rows_);
  at_rims_.clear();
  make_room(at_rims_, frame.table.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Index own = at(frame.bodies.body_of_point(), contacts.point[c]);
    if (frame.scales[c] < 1.0 && support_.lack(own, contacts.body[c]) > 0.0)
      at_rims_.push_back(static_cast<Index>(c));
  }
  const std::size_t chunks = parallel::chunk_count(at_rims_.size(), grain);
  if (searches_.size() < chunks) searches_.resize(chunks + chunks / 8 + 1);
  lists_.fill(frame.threads, at_rims_.size(), grain,
              [&](std::size_t begin, std::size_t end, std::vector<Row>& rows) {
                for (std::size_t i = begin; i < end; ++i)
                  add_rim_edges(frame, static_cast<std::size_t>(at_rims_[i]), searches_[begin / grain], rows);
              });
  lists_.append(rows_, chunks);
  std::ranges::sort(rows_, {}, [](const Row& row) { return row.state.key(); });
}

EdgeEnd EdgeResponse::state_of(const Row& row) {
  EdgeEnd state = row.state;
  state.points = row.coupling.points;
  state.coefficients = row.coupling.coefficients;
  state.slip = row.law.slip;
  state.direction = row.law.direction;
  state.depth = row.law.depth;
  state.stiffness = row.law.stiffness;
  state.acts = true;
  return state;
}

std::span<const EdgeResponse::Row> EdgeResponse::begin(const Frame& frame) {
  now_.swap(before_);
  list(frame);
  resize_with_room(now_, rows_.size());
  parallel::for_each(frame.threads, rows_.size(), grain, [&](std::size_t i) {
    Row& row = rows_[i];
    fem::ContactLaw& law = row.law;
    row.state.velocity = fem::relative(row.coupling, frame.velocities);
    const auto last = std::ranges::lower_bound(before_, row.state.key(), {}, &EdgeEnd::key);
    if (last != before_.end() && last->key() == row.state.key()) {
      if (last->lost == 0)
        law.slip = frame.rules.bounded_slip(last->slip + frame.time_step * row.state.velocity, law);
      const Index own = at(frame.bodies.body_of_point(), row.coupling.points[0]);
      row.state.chatter_damping =
          frame.rules.chatter_damping({.force = (last->stiffness * last->depth) * last->direction,
                                       .direction = last->direction,
                                       .velocity = last->velocity,
                                       .stiffness = last->stiffness,
                                       .damping = last->chatter_damping,
                                       .comes_back = last->lost > 0},
                                      (law.stiffness * law.depth) * law.direction, row.state.velocity,
                                      frame.rules.stiffness(own, row.state.body));
    }
    law.damping = frame.rules.damping(row.coupling, law.stiffness) + row.state.chatter_damping;
    now_[i] = state_of(row);
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
    Row row{.law = {.stiffness = last.stiffness, .damping = 0.0, .slip = {}, .direction = last.direction},
            .coupling = {},
            .state = last};
    row.coupling.points = last.points;
    row.coupling.coefficients = last.coefficients;
    const Vec3 apart = fem::relative(row.coupling, frame.positions);
    row.law.depth = last.depth - dot(apart, last.direction);
    const Vec3 slid = apart - dot(apart, last.direction) * last.direction;
    const double speed = length(fem::relative(row.coupling, frame.velocities));
    state.acts = row.law.depth <= 0.0 && -row.law.depth <= frame.time_step * speed + frame.fall &&
                 length(slid) <= frame.rules.rim_reach(last.body);
    if (state.acts) rows_.push_back(row);
  }
  std::inplace_merge(now_.begin(), now_.begin() + present, now_.end(),
                     [](const EdgeEnd& a, const EdgeEnd& b) { return a.key() < b.key(); });
  return rows_;
}

bool EdgeResponse::acts(const Row& row) const {
  const auto place = std::ranges::lower_bound(now_, row.state.key(), {}, &EdgeEnd::key);
  return place != now_.end() && place->key() == row.state.key() && place->acts;
}

std::span<const EdgeResponse::Row> EdgeResponse::meet(const Frame& frame) {
  list(frame);
  std::erase_if(rows_, [&](const Row& row) { return acts(row); });
  for (Row& row : rows_) {
    row.state = state_of(row);
    // Where it was before the step, along the straight line that it came: outside.
    row.state.velocity = fem::relative(row.coupling, frame.velocities);
    row.law.depth =
        std::min(row.law.depth + frame.time_step * dot(row.state.velocity, row.law.direction), 0.0);
    row.force =
        fem::contact_force(row.law, {.coefficient = 0.0, .time_step = frame.time_step}, row.state.velocity)
            .normal;
  }
  std::erase_if(rows_, [](const Row& row) { return row.force == 0.0; });
  return rows_;
}

void EdgeResponse::take() {
  make_room(now_, now_.size() + rows_.size());
  const auto known = static_cast<std::ptrdiff_t>(now_.size());
  for (const Row& row : rows_) {
    const auto here = std::span(now_).first(static_cast<std::size_t>(known));
    const auto gone = std::ranges::lower_bound(here, row.state.key(), {}, &EdgeEnd::key);
    if (gone == here.end() || gone->key() != row.state.key()) {
      now_.push_back(row.state);
      continue;
    }
    const std::int32_t lost = gone->lost;
    const double damping = gone->chatter_damping;
    *gone = row.state;
    gone->lost = lost;
    gone->chatter_damping = damping;
  }
  std::inplace_merge(now_.begin(), now_.begin() + known, now_.end(),
                     [](const EdgeEnd& a, const EdgeEnd& b) { return a.key() < b.key(); });
}

}  // namespace palpate

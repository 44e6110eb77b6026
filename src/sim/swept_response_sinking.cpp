// Contacts of the start of a step that would deepen within it, or leave on the other side, for SweptResponse.
#include <algorithm>
#include <array>

#include "geometry/triangle.hpp"
#include "room.hpp"
#include "sim/swept_response.hpp"

namespace palpate {
namespace {

/// Cosine of the angle between the directions at the start and the end of the step below which a contact
/// leaves on the other side. Over a rim, the direction turns by a right angle.
constexpr double other_side = -0.5;

}  // namespace

void SweptResponse::list_ends(std::span<const Vec3> positions, const EdgeContacts& contacts) {
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (contacts.direction[c] == Vec3{}) continue;
    const Edge& edge = at(bodies_.edges(), contacts.edge[c]);
    for (std::size_t end = 0; end < 2; ++end) {
      const Triangle& t = at(bodies_.triangles(), contacts.triangles[c][end]);
      const std::array<Vec3, 3> x = corners_of(positions, t);
      const double s = contacts.parameters[c][end];
      const auto w =
          weights_in(x, area_vector(x), (1.0 - s) * at(positions, edge[0]) + s * at(positions, edge[1]));
      Start& start = start_ends_.emplace_back();
      start.key = {SweptKind::edge_edge, contacts.edge[c],
                   -1 - (2 * contacts.body[c] + static_cast<Index>(end))};
      start.coupling.points = {edge[0], edge[1], t[0], t[1], t[2]};
      start.coupling.coefficients = {1.0 - s, s, -w[0], -w[1], -w[2]};
      start.direction = contacts.direction[c];
      start.depth = contacts.depth[c];
      start.in_thin =
          at(query_.thickness().of_triangle, contacts.triangles[c][end]) < at(thin_, contacts.body[c]);
    }
  }
}

/// Lists pairs of bodies whose contacts act softly, since they began deep: their first exits may be wrong.
void SweptResponse::list_soft_pairs(const ContactTable& contacts) {
  soft_pairs_.clear();
  const Contacts& points = contacts.contacts();
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (contacts.states().soft[c] == 0) continue;
    make_room(soft_pairs_, soft_pairs_.size() + 1);
    soft_pairs_.push_back(pair_of(at(bodies_.body_of_point(), points.point[c]), points.body[c]));
  }
  std::ranges::sort(soft_pairs_);
  soft_pairs_.erase(std::ranges::unique(soft_pairs_).begin(), soft_pairs_.end());
}

bool SweptResponse::is_soft(Index point, Index body) const {
  return std::ranges::binary_search(soft_pairs_, pair_of(at(bodies_.body_of_point(), point), body));
}

/// Adds the contacts of the start of the step that would deepen in this step by more than least_motion *
/// thickness, or leave on the other side. The sweep does not find these: their primitives overlap at the
/// start. Edge contacts are read from the detection, since most that are shallow have no law.
void SweptResponse::add_sinking(const PredictedStep& step, const ContactResponse& response,
                                std::span<const fem::Coupling> contacts) {
  const ContactTable& end = step.contacts;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (response.is_of_edge(c)) continue;
    const Index point = contacts[c].points[0];
    const Index body = at(bodies_.body_of_point(), contacts[c].points.back());
    const fem::ContactLaw& law = response.laws()[c];
    const Index row = end.find(point, body);
    const Side side = row < 0 ? Side::none : side_of(at(end.contacts().direction, row), law.direction);
    add_sinking({{SweptKind::point_triangle, point, body}, contacts[c], law.direction, law.depth}, side,
                false, step, response);
  }
  for (const Start& one : start_ends_) add_sinking(one, side_of_edge(one, end), true, step, response);
}

SweptResponse::Side SweptResponse::side_of(const Vec3& direction_end, const Vec3& direction) {
  return dot(direction_end, direction) < other_side ? Side::other : Side::same;
}

/// Where an edge has several contacts with the body at the end of the step, the side is the other one only if
/// it is so for all. An edge without contact is on the same side: perhaps one of its points is in contact
/// now. So is an edge in a body that is not thin: there the exit of a deep edge may jump although nothing
/// leads through. O(log(edge contacts)).
SweptResponse::Side SweptResponse::side_of_edge(const Start& start, const ContactTable& end) const {
  if (!start.in_thin) return Side::same;
  const EdgeContacts& edges = end.edges();
  const Index body = at(bodies_.body_of_point(), start.coupling.points.back());
  const auto [first, last] = std::ranges::equal_range(edges.edge, start.key.first);
  Side side = Side::same;
  for (auto row = first - edges.edge.begin(); row < last - edges.edge.begin(); ++row) {
    if (at(edges.body, row) != body) continue;
    side = side_of(at(edges.direction, row), start.direction);
    if (side == Side::same) break;
  }
  return side;
}

/// \param side  of the contact at the end of the step; none: there is no contact
void SweptResponse::add_sinking(const Start& start, Side side, bool of_edge, const PredictedStep& step,
                                const ContactResponse& response) {
  const Index body = at(bodies_.body_of_point(), start.coupling.points.back());
  const double thickness = at(query_.thickness().of_body, body);
  const double margin = margin_of_thickness * thickness;
  const double before = dot(start.direction, fem::relative(start.coupling, step.start));
  const double deeper = before - dot(start.direction, fem::relative(start.coupling, step.end));
  const bool sinks = deeper > settings().least_motion * thickness;
  // A shallow exit may change its direction by rounding alone.
  const bool leaves =
      start.depth > margin && (side == Side::other || (side == Side::none && deeper > margin));
  if (!sinks && !(leaves && !is_soft(start.coupling.points[0], body))) return;
  const double back = sinks ? 0.0 : margin;
  add(start.key,
      {start.coupling, start.direction, before + back, std::max(deeper, 0.0) + back, margin, of_edge}, step,
      response);
}

}  // namespace palpate

#include "contact/exits_back.hpp"

#include <algorithm>

#include "room.hpp"

namespace palpate {

/// Lists points in contacts, and ends of edges in contacts, that are deeper than contacts at the end of a
/// step may be.
void ExitsBack::list_deep(const ContactTable& contacts, std::vector<PointInBody>& deep) const {
  const Contacts& points = contacts.contacts();
  const EdgeContacts& edges = contacts.edges();
  deep.clear();
  make_room(deep, points.size() + 2 * edges.size());
  for (std::size_t c = 0; c < points.size(); ++c) {
    if (points.depth[c] > deepest_point * thickness_.of_contact(bodies_, points, c))
      deep.push_back({points.point[c], points.body[c]});
  }
  for (std::size_t c = 0; c < edges.size(); ++c) {
    if (!(edges.depth[c] > deepest_point * thickness_.of_contact(edges, c))) continue;
    for (const Index point : at(bodies_.edges(), edges.edge[c])) deep.push_back({point, edges.body[c]});
  }
  std::ranges::sort(deep);
}

/// Whether one of the primitives has a point in a contact that is deep at the end of the step, and was not
/// at its start: then the bodies overlap further than this pair does, and its own contact is not enough.
bool ExitsBack::becomes_deep(const SweptContact& contact) const {
  const auto any = [&](std::span<const Index> points, Index body) {
    return std::ranges::any_of(points, [&](Index point) {
      const PointInBody one{point, body};
      return std::ranges::binary_search(deep_end_, one) && !std::ranges::binary_search(deep_start_, one);
    });
  };
  if (contact.kind == SweptKind::point_triangle) {
    const Triangle& triangle = at(bodies_.triangles(), contact.second);
    return any(std::span(&contact.first, 1), bodies_.body_of(triangle)) ||
           any(triangle, at(bodies_.body_of_point(), contact.first));
  }
  const Edge& a = at(bodies_.edges(), contact.first);
  const Edge& b = at(bodies_.edges(), contact.second);
  return any(a, bodies_.body_of(b)) || any(b, bodies_.body_of(a));
}

bool ExitsBack::point_leads(Index point, Index body, const Vec3& back, double deepest) const {
  const Index row = end_->find(point, body);
  return row >= 0 && dot(at(end_->contacts().direction, row), back) > 0.0 &&
         at(end_->contacts().depth, row) <= deepest;
}

bool ExitsBack::edge_leads(Index edge, Index body, const Vec3& back, double deepest) const {
  const EdgeContacts& edges = end_->edges();
  return std::ranges::any_of(rows_of_edge(edges, edge), [&](std::size_t row) {
    return edges.body[row] == body && dot(edges.direction[row], back) > 0.0 && edges.depth[row] <= deepest;
  });
}

bool ExitsBack::has_exit(const SweptContact& contact, const EndBehind& end) const {
  if (becomes_deep(contact)) return false;
  const double deepest = std::max(deepest_point * end.thick, end.before + deepest_edge * end.thick);
  if (contact.kind == SweptKind::point_triangle) {
    const Index body = bodies_.body_of(at(bodies_.triangles(), contact.second));
    return end.beyond <= deepest && point_leads(contact.first, body, end.back, deepest);
  }
  const Edge& a = at(bodies_.edges(), contact.first);
  const Edge& b = at(bodies_.edges(), contact.second);
  const Index body_a = bodies_.body_of(a);
  const Index body_b = bodies_.body_of(b);
  if (end.beyond <= deepest && (edge_leads(contact.first, body_b, end.back, deepest) ||
                                edge_leads(contact.second, body_a, -end.back, deepest)))
    return true;
  if (end.beyond > end.before + deepest_edge * end.thick) return false;
  return std::ranges::any_of(a, [&](Index p) { return point_leads(p, body_b, end.back, deepest); }) ||
         std::ranges::any_of(b, [&](Index p) { return point_leads(p, body_a, -end.back, deepest); });
}

}  // namespace palpate

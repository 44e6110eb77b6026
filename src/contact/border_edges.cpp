#include "contact/border_edges.hpp"

#include "contact/layers.hpp"
#include "room.hpp"

namespace palpate {

BorderEdges::BorderEdges(const Bodies& bodies) {
  neighbors_.begin = bodies.point_edges().begin;
  neighbors_.values.reserve(bodies.point_edges().values.size());
  for (Index point = 0; point < static_cast<Index>(bodies.points_rest().size()); ++point) {
    for (const Index edge : bodies.point_edges()[point])
      neighbors_.values.push_back(bodies.other_end(edge, point));
  }
}

struct BorderEdges::Part {
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const ContactTable& table;
  std::span<const std::uint8_t> without;
};

/// Writes the edges of one contact; border edges are written to `edge`, which advances. There is no branch on
/// the kind of an edge, because it is unpredictable.
void BorderEdges::part(const Part& what, std::size_t c, BorderEdge*& edge) {
  const Contacts& contacts = what.table.contacts();
  const Index point = contacts.point[c];
  const Index body = contacts.body[c];
  const bool own = at(what.bodies.body_of_point(), point) == body;
  BorderEdge* border = edge;
  const std::ptrdiff_t border_step = what.without.empty() || what.without[c] == 0 ? 1 : 0;
  Index* link = links_.data() + ranges_[c].begin;
  for (const Index other : neighbors_[point]) {
    Index neighbor = what.table.find(other, body);
    if (own && neighbor >= 0 &&
        !same_layer(what.bodies, what.positions, point, contacts.tet[c], other, at(contacts.tet, neighbor)))
      neighbor = -1;
    *border = {static_cast<Index>(c), other};
    border += neighbor < 0 ? border_step : 0;
    *link = neighbor;
    link += neighbor < 0 ? 0 : 1;
  }
  edge = border;
  ranges_[c].end = static_cast<Index>(link - links_.data());
}

void BorderEdges::find(const parallel::Threads& threads, const Bodies& bodies,
                       std::span<const Vec3> positions, const ContactTable& table,
                       std::span<const std::uint8_t> without) {
  const std::vector<Index>& points = table.contacts().point;
  resize_with_room(ranges_, points.size());
  Index room = 0;
  for (std::size_t c = 0; c < points.size(); ++c) {
    ranges_[c].begin = room;
    room += static_cast<Index>(neighbors_[points[c]].size()) +
            1;  // each edge is written to both lists, and counted in one
  }
  resize_with_room(links_, static_cast<std::size_t>(room));
  const Part what{bodies, positions, table, without};
  lists_.fill(threads, points.size(), 256,
              [&](std::size_t begin, std::size_t end, std::vector<BorderEdge>& found) {
                const Index last = end < points.size() ? ranges_[end].begin : room;
                make_room(found, static_cast<std::size_t>(last - ranges_[begin].begin));
                found.resize(static_cast<std::size_t>(last - ranges_[begin].begin));
                BorderEdge* edge = found.data();
                for (std::size_t c = begin; c < end; ++c) part(what, c, edge);
                found.resize(static_cast<std::size_t>(edge - found.data()));
              });
  lists_.join(threads, edges_);
}

}  // namespace palpate

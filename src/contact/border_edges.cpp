#include "contact/border_edges.hpp"

#include "contact/layers.hpp"

namespace palpate {

void find_border_edges(const parallel::Threads& threads, const Bodies& bodies,
                       std::span<const Vec3> positions, const ContactList& list,
                       parallel::ChunkedList<BorderEdge>& scratch, std::vector<BorderEdge>& border_edges) {
  const Contacts& contacts = list.contacts();
  scratch.fill(
      threads, contacts.size(), 256, [&](std::size_t begin, std::size_t end, std::vector<BorderEdge>& found) {
        for (std::size_t c = begin; c < end; ++c) {
          const Index point = contacts.point[c];
          for (const Index edge : bodies.point_edges()[point]) {
            const Index other = bodies.other_end(edge, point);
            const Index neighbor = list.find(other, contacts.body[c]);
            const bool linked = neighbor >= 0 && (at(bodies.body_of_point(), point) != contacts.body[c] ||
                                                  same_layer(bodies, positions, point, contacts.tet[c], other,
                                                             at(contacts.tet, neighbor)));
            if (!linked) found.push_back({static_cast<Index>(c), other});
          }
        }
      });
  scratch.join(border_edges);
}

}  // namespace palpate

#include "contact/border_edges.hpp"

namespace palpate {

void find_border_edges(const parallel::Threads& threads, const Bodies& bodies, const ContactList& list,
                       parallel::ChunkedList<BorderEdge>& scratch, std::vector<BorderEdge>& border_edges) {
  const Contacts& contacts = list.contacts();
  scratch.fill(threads, contacts.size(), 256,
               [&](std::size_t begin, std::size_t end, std::vector<BorderEdge>& found) {
                 for (std::size_t c = begin; c < end; ++c) {
                   const Index point = contacts.point[c];
                   for (const Index edge : bodies.point_edges()[point]) {
                     const Index other = bodies.other_end(edge, point);
                     if (list.find(other, contacts.body[c]) < 0)
                       found.push_back({static_cast<Index>(c), other});
                   }
                 }
               });
  scratch.join(border_edges);
}

}  // namespace palpate

#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// The border edges of a detection, and the contacts at their ends. Loops that write should copy it, so that
/// its pointers stay in registers.
class BorderEdgeView {
 public:
  BorderEdgeView(const Contacts& contacts, std::span<const BorderEdge> edges)
      : point_(contacts.point), body_(contacts.body), edges_(edges) {}

  [[nodiscard]] std::size_t size() const { return edges_.size(); }
  [[nodiscard]] std::span<const BorderEdge> edges() const { return edges_; }
  /// (n_contacts) their points.
  [[nodiscard]] std::span<const Index> points() const { return point_; }
  /// The point of a contact, and the body that it is in.
  [[nodiscard]] Index point(Index contact) const { return at(point_, contact); }
  [[nodiscard]] Index body_of(Index contact) const { return at(body_, contact); }
  /// The point in contact, then the free one.
  [[nodiscard]] std::array<Index, 2> ends(Index edge) const {
    const BorderEdge& e = at(edges_, edge);
    return {at(point_, e.contact), e.free_point};
  }
  /// The penetrated body.
  [[nodiscard]] Index body(Index edge) const { return at(body_, at(edges_, edge).contact); }
  /// Marks the penetrated bodies.
  /// \param marks  (n_bodies) 1 for these, otherwise 0
  void mark_bodies(std::vector<std::uint8_t>& marks, std::size_t bodies) const {
    marks.assign(bodies, 0);
    Index last = -1;
    for (const BorderEdge& edge : edges_) {
      if (edge.contact == last) continue;
      last = edge.contact;
      at(marks, at(body_, last)) = 1;
    }
  }

 private:
  std::span<const Index> point_;  ///< (n_contacts)
  std::span<const Index> body_;   ///< (n_contacts)
  std::span<const BorderEdge> edges_;
};

}  // namespace palpate

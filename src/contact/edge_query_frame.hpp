#pragma once

#include "contact/edge_query.hpp"
#include "simd/reached_pairs.hpp"

namespace palpate {

/// Input of EdgeQuery::find() that all its steps use.
struct EdgeQuery::Frame {
  const parallel::Threads& threads;
  const Bodies& bodies;
  std::span<const Vec3> positions;
  const PairFilter& may_touch;
  const ContactTable& contacts;
  const Deadline& deadline;
  SurfaceFrame surface;

  [[nodiscard]] simd::ContactsOfEdges contacts_of_edges(const IndexPair& of) const {
    static_assert(sizeof(ContactTable::OfPoint) == 3 * sizeof(Index));
    return {bodies.edges().data(), &contacts.of_points().data()->first, of.first, of.second,
            at(bodies.bodies(), of.first).points};
  }
  /// Whether an end of an edge of one of two bodies is in contact with the other one.
  [[nodiscard]] bool has_end_in_contact(Index edge, const IndexPair& of) const {
    const Edge& ends = at(bodies.edges(), edge);
    const Index body = at(bodies.body_of_point(), ends[0]) == of.first ? of.second : of.first;
    return contacts.find(ends[0], body) >= 0 || contacts.find(ends[1], body) >= 0;
  }
};

}  // namespace palpate

#pragma once

#include "contact/edge_query.hpp"

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

  /// Whether an end of an edge of one of two bodies is in contact with the other one.
  [[nodiscard]] bool has_end_in_contact(Index edge, const IndexPair& of) const {
    const Edge& ends = at(bodies.edges(), edge);
    const bool is_of_first = at(bodies.bodies(), of.first).points.contains(ends[0]);
    const Index body = is_of_first ? of.second : of.first;
    return contacts.find(ends[0], body) >= 0 || contacts.find(ends[1], body) >= 0;
  }
};

}  // namespace palpate

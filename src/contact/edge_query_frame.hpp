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
  FacingClusters::Frame facing;

  [[nodiscard]] bool has_end_in_contact(Index edge, Index body) const {
    const Edge& ends = at(bodies.edges(), edge);
    return contacts.find(ends[0], body) >= 0 || contacts.find(ends[1], body) >= 0;
  }
};

}  // namespace palpate

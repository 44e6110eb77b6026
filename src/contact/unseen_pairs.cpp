#include "contact/unseen_pairs.hpp"

#include <algorithm>

#include "contact/rim_falloff.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Relative to the width of the rim: far more than rounding errors, far less than what matters.
constexpr double least_depth = 1e-5;

}  // namespace

UnseenPairs::UnseenPairs(const Bodies& bodies, bool keeps_lists) : query_(bodies, keeps_lists) {
  for (Index b = 0; b < bodies.body_count(); ++b) least_depth_.push_back(least_depth * rim_reach(bodies, b));
}

/// Lists the pairs of bodies that need not be searched: those that are ignored, and those with a contact.
void UnseenPairs::leave_out_contacts(const Frame& frame, const ContactTable& contacts) {
  const PairFilter filter = frame.may_touch();
  pairs_.assign(filter.ignored_pairs.begin(), filter.ignored_pairs.end());
  self_collision_.assign(filter.self_collision.begin(), filter.self_collision.end());
  const Contacts& rows = contacts.contacts();
  for (std::size_t c = 0; c < rows.size(); ++c) {
    const Index own = at(frame.bodies().body_of_point(), rows.point[c]);
    if (own == rows.body[c]) {
      at(self_collision_, own) = 0;
      continue;
    }
    const std::array pair{std::min(own, rows.body[c]), std::max(own, rows.body[c])};
    if (!pairs_.empty() && pairs_.back() == pair) continue;
    make_room(pairs_, pairs_.size() + 1);
    pairs_.push_back(pair);
  }
  std::ranges::sort(pairs_);
  pairs_.erase(std::ranges::unique(pairs_).begin(), pairs_.end());
}

std::size_t UnseenPairs::count(const Frame& frame, const ContactTable& contacts, const Deadline& deadline) {
  leave_out_contacts(frame, contacts);
  PairFilter filter = frame.may_touch();
  filter.ignored_pairs = pairs_;
  filter.self_collision = self_collision_;
  const Bodies& bodies = frame.bodies();
  query_.find(frame.threads(), bodies, frame.positions(), filter, contacts, found_, deadline);
  pairs_.clear();
  for (std::size_t e = 0; e < found_.size(); ++e) {
    const Index body = found_.body[e];
    const Index own = bodies.body_of(at(bodies.edges(), found_.edge[e]));
    if (found_.depth[e] <= std::min(at(least_depth_, own), at(least_depth_, body))) continue;
    make_room(pairs_, pairs_.size() + 1);
    pairs_.push_back({std::min(own, body), std::max(own, body)});
  }
  std::ranges::sort(pairs_);
  return static_cast<std::size_t>(std::ranges::unique(pairs_).begin() - pairs_.begin());
}

}  // namespace palpate

// Plans of the search of edges: the margins of lists; with a deadline, what comes first and what was left
// out.
#include <algorithm>
#include <numeric>
#include <tuple>

#include "contact/edge_query.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Number of detections like the last one for which a list has a margin.
constexpr double detections = 12.0;
/// The smallest margin of a list, over the largest one.
constexpr double least_room = 1e-3;
/// Number of detections after its own that a list must serve. Making it costs about as much as to test all
/// near edges without one.
constexpr std::size_t fewest_served = 2;
/// Least number of detections that the margin must cover; faster pairs are listed each time.
constexpr double fewest_detections = 3.0;
/// Number of lists without a margin after a margin that did not pay; four times as many each time.
constexpr int shortest_patience = 8;
constexpr int longest_patience = 2048;

}  // namespace

/// Plans the next list of a pair from its last one: its margin, or 0 for none.
double EdgeQuery::room_for(NearPair& pair) const {
  if (pair.room > 0.0) {
    const bool paid = pair.served >= fewest_served;
    pair.patience = paid ? shortest_patience : std::min(4 * pair.patience, longest_patience);
    pair.left_bare = paid ? 0 : pair.patience;
  }
  const double most = at(most_room_, pair.bodies.first) + at(most_room_, pair.bodies.second);
  const double least = least_room * most;
  const bool waits = pair.left_bare > 0 && (pair.usual > least || pair.room < 0.0);
  if (waits || fewest_detections * pair.usual > most) {
    pair.left_bare = std::max(0, pair.left_bare - 1);
    return 0.0;
  }
  return std::clamp(detections * pair.usual, least, most);
}

/// Orders the pairs: those that have waited too long, those that found edges last time, then all others.
void EdgeQuery::order_pairs() {
  constexpr int too_long = 31;
  resize_with_room(order_, pairs_.size());
  std::iota(order_.begin(), order_.end(), std::size_t{0});
  if (!is_timed_) return;
  std::ranges::sort(order_, {}, [&](std::size_t i) {
    const NearPair& pair = pairs_[i];
    return std::tuple(pair.waited < too_long, !pair.has_found, -pair.waited, i);
  });
}

/// Clusters that were left out when a pair was listed come first the next time.
void EdgeQuery::rotate_clusters() {
  if (!is_timed_) return;
  for (std::size_t begin = 0; begin < facing_.size();) {
    std::size_t end = begin + 1;
    while (end < facing_.size() && facing_[end].number == facing_[begin].number) ++end;
    const auto clusters = facing_.subspan(begin, end - begin);
    const std::size_t done = at(pairs_, facing_[begin].number).listed % clusters.size();
    std::ranges::rotate(clusters, clusters.begin() + static_cast<std::ptrdiff_t>(done));
    begin = end;
  }
}

/// After a listing: pairs of which clusters were left out are listed again in the next detection.
void EdgeQuery::leave_out_clusters() {
  if (!is_timed_) return;
  work_.all += facing_.size();
  std::size_t first = 0;  // of the pair
  for (std::size_t i = 0; i < facing_.size(); ++i) {
    if (facing_[i].number != facing_[first].number) first = i;
    if (!listing_.skipped(i)) continue;
    ++work_.late;
    NearPair& pair = at(pairs_, facing_[i].number);
    if (!pair.is_partial) pair.listed += i - first;
    pair.is_partial = pair.is_late = true;
  }
}

/// After the tests: groups that were left out come first the next time. Their motion until then is bounded by
/// that of the bodies.
void EdgeQuery::leave_out_groups() {
  if (!is_timed_) return;
  work_.all += begin_.back();
  for (std::size_t k = 0; k < order_.size(); ++k) {
    NearPair& pair = pairs_[order_[k]];
    std::size_t first = pair.groups.size();
    for (std::size_t g = pair.groups.size(); g-- > 0;) {
      if (!testing_.skipped(begin_[k] + g)) continue;
      ++work_.late;
      pair.is_late = true;
      pair.groups[g].moved = unknown_motion;
      first = g;
    }
    std::ranges::rotate(pair.groups, pair.groups.begin() + static_cast<std::ptrdiff_t>(first));
  }
}

/// Call after the search: counts waiting pairs, and notes those that found edges.
void EdgeQuery::end_pairs(const Bodies& bodies) {
  if (!is_timed_) return;
  for (NearPair& pair : pairs_) {
    pair.has_found = false;
    pair.waited = pair.is_late ? pair.waited + 1 : 0;
    if (!pair.is_late) continue;
    make_room(work_.late_pairs, work_.late_pairs.size() + 1);
    work_.late_pairs.push_back(pair.bodies);
  }
  for (const EdgeTriangle& hit : found_) {
    const auto [low, high] = std::minmax(bodies.body_of(at(bodies.edges(), hit.edge)),
                                         bodies.body_of(at(bodies.triangles(), hit.triangle)));
    const auto pair = std::ranges::lower_bound(pairs_, IndexPair(low, high), {}, &NearPair::bodies);
    if (pair != pairs_.end()) pair->has_found = true;
  }
}

}  // namespace palpate

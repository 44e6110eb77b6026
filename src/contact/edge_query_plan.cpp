// Plans of the search of edges: the margins of lists; with a deadline, what comes first and what was left
// out.
#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "contact/edge_query.hpp"
#include "room.hpp"

namespace palpate {
namespace {

/// Number of detections like the last one for which a list has a margin.
constexpr double detections = 30.0;
/// Least number of detections that a margin must cover; what moves faster is listed each time.
constexpr double fewest_detections = 1.0;
/// The margin of a list where no motion is known yet, over the largest one.
constexpr double first_room = 0.05;
/// The smallest margin of a list, over the largest one.
constexpr double least_room = 1e-3;
/// The largest margin of a list of clusters, over the sum of the reaches of both bodies.
constexpr double room_of_clusters = 2.0;

}  // namespace

/// \param usual  relative motion per detection, m
/// \param most   the largest margin, m
double EdgeQuery::margin_of_list(double usual, double most) const {
  if (!keeps_lists_) return 0.0;
  if (usual == 0.0) return first_room * most;
  if (fewest_detections * usual > most) return 0.0;
  return std::clamp(detections * usual, least_room * most, most);
}

double EdgeQuery::most_room(const NearPair& pair) const {
  return room_of_clusters * (at(reach_, pair.bodies.first) + at(reach_, pair.bodies.second));
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

/// After the tests: groups that were left out come first the next time.
void EdgeQuery::leave_out_tasks() {
  if (!is_timed_) return;
  work_.all += begin_.back();
  for (NearPair& pair : pairs_) pair.is_late = false;
  for (std::size_t i = 0; i < tasks_.size(); ++i) {
    if (tasks_[i].is_listed && !testing_.skipped(i)) continue;
    ++work_.late;
    NearPair& pair = pairs_[tasks_[i].pair];
    if (!std::exchange(pair.is_late, true)) pair.first = tasks_[i].group;
  }
}

/// Call after the search: counts waiting pairs, and marks those that found edges.
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
    const auto [low, high] = std::minmax(
        {bodies.body_of(at(bodies.edges(), hit.edge)), bodies.body_of(at(bodies.triangles(), hit.triangle))});
    const auto pair = std::ranges::lower_bound(pairs_, IndexPair(low, high), {}, &NearPair::bodies);
    if (pair != pairs_.end()) pair->has_found = true;
  }
}

}  // namespace palpate

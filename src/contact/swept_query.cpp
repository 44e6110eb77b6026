#include "contact/swept_query.hpp"

#include <algorithm>

#include "geometry/axis.hpp"
#include "geometry/box.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t swept_cluster_grain = 64;

}  // namespace

SweptQuery::SweptQuery(const Bodies& bodies)
    : bodies_(bodies),
      surface_(bodies),
      thickness_(bodies, surface_.clusters),
      clusters_(surface_.clusters.clusters.size()),
      of_bodies_(bodies.bodies().size()),
      marked_(clusters_.size(), 0) {}

std::span<const SweptContact> SweptQuery::find(const parallel::Threads& threads, std::span<const Vec3> start,
                                               std::span<const Vec3> end, const PairFilter& filter,
                                               const SweptSettings& settings) {
  return find(threads, start, start, end, filter, settings);
}

std::span<const SweptContact> SweptQuery::find(const parallel::Threads& threads, std::span<const Vec3> start,
                                               std::span<const Vec3> from, std::span<const Vec3> end,
                                               const PairFilter& filter, const SweptSettings& settings) {
  begin({threads, start, end, filter, settings}, from);
  if (body_pairs_.empty()) return contacts_;
  const Step step{threads, from, end, filter, settings};
  mark_clusters();
  find_cluster_pairs(step);
  count_cluster_pairs();
  test_pairs(step);
  return contacts_;
}

void SweptQuery::count(const parallel::Threads& threads, std::span<const Vec3> start,
                       std::span<const Vec3> end, const PairFilter& filter, const SweptSettings& settings) {
  if (!may_pass(threads, start, end, filter, settings)) return;
  mark_clusters();
  find_cluster_pairs({threads, start, end, filter, settings});
  count_cluster_pairs();
}

bool SweptQuery::may_pass(const parallel::Threads& threads, std::span<const Vec3> start,
                          std::span<const Vec3> end, const PairFilter& filter,
                          const SweptSettings& settings) {
  begin({threads, start, end, filter, settings}, start);
  return !body_pairs_.empty();
}

/// \param from  where the paths begin
void SweptQuery::begin(const Step& step, std::span<const Vec3> from) {
  counts_ = {};
  contacts_.clear();
  sweep_clusters(step);
  if (from.data() != step.start.data()) extend_places(step, from);
  sweep_bodies();
  find_body_pairs(step);
}

/// Boxes grow by rounding errors of positions and by the tolerance, so that touches within it are found, too.
void SweptQuery::sweep_clusters(const Step& step) {
  parallel::for_each(step.threads, clusters_.size(), swept_cluster_grain, [&](std::size_t c) {
    Swept swept;
    for (const Index p : surface_.clusters.points_of(surface_.clusters.clusters[c])) {
      const Vec3& from = at(step.start, p);
      const Vec3& to = at(step.end, p);
      swept.places.extend(from);
      swept.places.extend(to);
      swept.motion.extend(to - from);
    }
    swept.places = grown(swept.places, step.settings.tolerance);
    clusters_[c] = swept;
  });
}

/// Extends the boxes of positions by other positions at the start of the step.
void SweptQuery::extend_places(const Step& step, std::span<const Vec3> from) {
  parallel::for_each(step.threads, clusters_.size(), swept_cluster_grain, [&](std::size_t c) {
    Box places;
    for (const Index p : surface_.clusters.points_of(surface_.clusters.clusters[c]))
      places.extend(at(from, p));
    clusters_[c].places.extend(grown(places, step.settings.tolerance));
  });
}

void SweptQuery::sweep_bodies() {
  for (std::size_t b = 0; b < of_bodies_.size(); ++b) {
    Swept swept;
    const Range& range = surface_.of_body[b];
    for (Index c = range.begin; c < range.end; ++c) {
      swept.places.extend(at(clusters_, c).places);
      swept.motion.extend(at(clusters_, c).motion);
    }
    of_bodies_[b] = swept;
  }
}

bool SweptQuery::may_touch(const PairFilter& filter, Index a, Index b) const {
  const bool one_moves = at(filter.immovable, a) == 0 || at(filter.immovable, b) == 0;
  if (a != b) return one_moves && !filter.ignores(a, b);
  return one_moves && !filter.self_collision.empty() && at(filter.self_collision, a) != 0;
}

/// Sweeps along x to find pairs of bodies; includes a body with itself.
void SweptQuery::find_body_pairs(const Step& step) {
  body_pairs_.clear();
  by_lower_.clear();
  make_room(by_lower_, of_bodies_.size());
  for (Index b = 0; b < bodies_.body_count(); ++b)
    if (at(surface_.of_body, b).size() > 0) by_lower_.push_back(b);
  std::sort(by_lower_.begin(), by_lower_.end(), [&](Index a, Index b) {
    const double low_a = at(of_bodies_, a).places.lower.x;
    const double low_b = at(of_bodies_, b).places.lower.x;
    return low_a != low_b ? low_a < low_b : a < b;
  });
  for (std::size_t i = 0; i < by_lower_.size(); ++i) {
    const Swept& first = at(of_bodies_, by_lower_[i]);
    for (std::size_t j = i; j < by_lower_.size(); ++j) {
      const Index a = std::min(by_lower_[i], by_lower_[j]);
      const Index b = std::max(by_lower_[i], by_lower_[j]);
      const Swept& second = at(of_bodies_, by_lower_[j]);
      if (second.places.lower.x > first.places.upper.x) break;
      if (!first.places.overlaps(second.places)) continue;
      const double thickness = std::min(at(thickness_.of_body, a), at(thickness_.of_body, b));
      if (!(furthest(first.motion, second.motion) > step.settings.least_motion * thickness)) continue;
      if (!may_touch(step.filter, a, b)) continue;
      make_room(body_pairs_, body_pairs_.size() + 1);
      body_pairs_.push_back({a, b});
    }
  }
  std::sort(body_pairs_.begin(), body_pairs_.end());
}

/// Number of a pair of clusters' bodies in body_pairs_; -1 if it is not there.
std::ptrdiff_t SweptQuery::body_pair_of(const Pair& clusters) const {
  const Index a = at(surface_.clusters.clusters, clusters[0]).body;
  const Index b = at(surface_.clusters.clusters, clusters[1]).body;
  const Pair wanted{std::min(a, b), std::max(a, b)};
  const auto found = std::ranges::lower_bound(body_pairs_, wanted);
  return found != body_pairs_.end() && *found == wanted ? found - body_pairs_.begin() : -1;
}

/// The boxes of bodies meet more often than the bodies, so what could pass is counted by clusters.
void SweptQuery::count_cluster_pairs() {
  counts_.cluster_pairs = pairs_.size();
  assign_with_room(has_clusters_, body_pairs_.size(), std::uint8_t{0});
  for (const Pair& pair : pairs_) {
    at(has_clusters_, body_pair_of(pair)) = 1;
    const double thickness = std::min(at(thickness_.of_cluster, pair[0]), at(thickness_.of_cluster, pair[1]));
    counts_.thinnest = counts_.thinnest > 0.0 ? std::min(counts_.thinnest, thickness) : thickness;
  }
  counts_.body_pairs = static_cast<std::size_t>(std::ranges::count(has_clusters_, 1));
}

/// Marks the clusters that meet the swept box of the other body.
void SweptQuery::mark_clusters() {
  std::fill(marked_.begin(), marked_.end(), 0);
  const auto mark = [&](Index body, Index other) {
    const Box& box = at(of_bodies_, other).places;
    const Range& range = at(surface_.of_body, body);
    for (Index c = range.begin; c < range.end; ++c)
      if (at(clusters_, c).places.overlaps(box)) at(marked_, c) = 1;
  };
  for (const Pair& pair : body_pairs_) {
    mark(pair[0], pair[1]);
    if (pair[0] != pair[1]) mark(pair[1], pair[0]);
  }
}

/// Sweeps along the longest axis of the marked clusters to find pairs of clusters.
void SweptQuery::find_cluster_pairs(const Step& step) {
  by_lower_.clear();
  make_room(by_lower_, clusters_.size());
  Box all;
  for (std::size_t c = 0; c < clusters_.size(); ++c) {
    if (marked_[c] == 0) continue;
    by_lower_.push_back(static_cast<Index>(c));
    all.extend(clusters_[c].places);
  }
  const std::size_t axis = longest_axis(all.upper - all.lower);
  const auto lower = [&](Index c) { return along(axis, at(clusters_, c).places.lower); };
  std::sort(by_lower_.begin(), by_lower_.end(),
            [&](Index a, Index b) { return lower(a) != lower(b) ? lower(a) < lower(b) : a < b; });
  pair_lists_.fill(
      step.threads, by_lower_.size(), swept_cluster_grain,
      [&](std::size_t begin, std::size_t end, std::vector<Pair>& list) {
        for (std::size_t i = begin; i < end; ++i) {
          const Index a = by_lower_[i];
          const Swept& first = at(clusters_, a);
          const double upper = along(axis, first.places.upper);
          for (std::size_t j = i; j < by_lower_.size() && lower(by_lower_[j]) <= upper; ++j) {
            const Index b = by_lower_[j];
            const Swept& second = at(clusters_, b);
            if (!first.places.overlaps(second.places)) continue;
            const double thickness = std::min(at(thickness_.of_cluster, a), at(thickness_.of_cluster, b));
            if (!(furthest(first.motion, second.motion) > step.settings.least_motion * thickness)) continue;
            const Pair pair{std::min(a, b), std::max(a, b)};
            if (body_pair_of(pair) >= 0) list.push_back(pair);
          }
        }
      });
  pair_lists_.join(step.threads, pairs_);
}

}  // namespace palpate

#include "contact/depth.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "contact/nearest_surface.hpp"
#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t grain = 256;

/// Weighted means of depth and direction; what the border and the propagation have in common.
class WeightedEstimate {
 public:
  WeightedEstimate() = default;
  /// \param offset  from the point to the place that the estimate comes from; its weight is 1 / |offset|^2,
  /// and an
  ///                estimate from the point itself rules out all others
  void add(const Vec3& offset, double depth, const Vec3& direction) {
    const double l2 = squared_length(offset);
    const bool here = l2 < smallest_;
    if (here && !at_point_) *this = WeightedEstimate(true);
    if (at_point_ && !here) return;
    const double weight = here ? 1.0 : 1.0 / l2;
    sum_ += weight;
    depth_ += weight * depth;
    direction_ += weight * direction;
  }
  [[nodiscard]] double depth() const { return depth_ / sum_; }
  [[nodiscard]] Vec3 direction() const { return normalized(direction_); }
  [[nodiscard]] bool usable() const {
    return sum_ > 0.0 && std::isfinite(depth()) && depth() >= 0.0 && direction() != Vec3{};
  }

 private:
  explicit WeightedEstimate(bool at_point) : at_point_(at_point) {}

  static constexpr double smallest_ = 1e-200;  ///< below it the weight would overflow
  double sum_ = 0.0;
  double depth_ = 0.0;
  Vec3 direction_;
  bool at_point_ = false;  ///< an estimate came from the point itself: only such ones count
};

}  // namespace

std::size_t DepthEstimate::compute(const parallel::Threads& threads, const Bodies& bodies,
                                   std::span<const Vec3> positions, ContactList& list,
                                   std::span<const BorderEdge> border_edges, const CrossingQuery& crossings) {
  Contacts& contacts = list.contacts();
  mark_border_edges(contacts.size(), border_edges);
  estimate_border(threads, bodies, positions, contacts, border_edges, crossings);
  propagate(threads, bodies, positions, list);
  parallel::for_each(threads, contacts.size(), 16, [&](std::size_t c) {
    if (level_[c] == unreached) take_nearest_surface(bodies, positions, contacts, c);
  });
  return std::accumulate(fallback_.begin(), fallback_.end(), std::size_t{0});
}

void DepthEstimate::take_nearest_surface(const Bodies& bodies, std::span<const Vec3> positions,
                                         Contacts& contacts, std::size_t c) {
  const SurfacePoint nearest =
      nearest_surface_point(bodies, positions, contacts.body[c], at(positions, contacts.point[c]));
  contacts.depth[c] = nearest.distance;
  contacts.direction[c] = nearest.outward;
  fallback_[c] = 1;
}

void DepthEstimate::mark_border_edges(std::size_t contacts, std::span<const BorderEdge> border_edges) {
  assign_with_room(border_begin_, contacts + 1, Index{0});
  for (const BorderEdge& edge : border_edges) ++at(border_begin_, edge.contact + 1);
  std::partial_sum(border_begin_.begin(), border_begin_.end(), border_begin_.begin());
}

void DepthEstimate::estimate_border(const parallel::Threads& threads, const Bodies& bodies,
                                    std::span<const Vec3> positions, Contacts& contacts,
                                    std::span<const BorderEdge> border_edges,
                                    const CrossingQuery& crossings) {
  assign_with_room(level_, contacts.size(), unreached);
  assign_with_room(fallback_, contacts.size(), std::uint8_t{0});
  parallel::for_each(threads, contacts.size(), grain, [&](std::size_t c) {
    const Vec3& p = at(positions, contacts.point[c]);
    WeightedEstimate estimate;
    for (Index e = border_begin_[c]; e < border_begin_[c + 1]; ++e) {
      const auto first = crossings.crossings().begin() + at(crossings.begin(), e);
      const auto last = crossings.crossings().begin() + at(crossings.begin(), e + 1);
      if (first == last) continue;
      const Crossing& exit = *std::max_element(
          first, last, [](const Crossing& a, const Crossing& b) { return a.parameter < b.parameter; });
      const Triangle& t = at(bodies.triangles(), exit.triangle);
      const Vec3 normal = normalized(
          cross(at(positions, t[1]) - at(positions, t[0]), at(positions, t[2]) - at(positions, t[0])));
      const Vec3 offset = exit.parameter * (at(positions, at(border_edges, e).free_point) - p);
      estimate.add(offset, dot(offset, normal), normal);
      level_[c] = 0;
    }
    if (level_[c] == unreached) return;
    if (estimate.usable()) {
      contacts.depth[c] = estimate.depth();
      contacts.direction[c] = estimate.direction();
    } else {
      take_nearest_surface(bodies, positions, contacts, c);
    }
  });
}

void DepthEstimate::next_level(const Bodies& bodies, const ContactList& list, Index level) {
  const Contacts& contacts = list.contacts();
  next_.clear();
  for (const Index c : frontier_) {
    const Index point = at(contacts.point, c);
    for (const Index edge : bodies.point_edges()[point]) {
      const Index other = list.find(bodies.other_end(edge, point), at(contacts.body, c));
      if (other < 0 || at(level_, other) != unreached) continue;
      at(level_, other) = level;
      next_.push_back(other);
    }
  }
  std::swap(frontier_, next_);
}

void DepthEstimate::propagate(const parallel::Threads& threads, const Bodies& bodies,
                              std::span<const Vec3> positions, ContactList& list) {
  Contacts& contacts = list.contacts();
  frontier_.clear();
  make_room(frontier_, contacts.size());
  make_room(next_, contacts.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    if (level_[c] == 0) frontier_.push_back(static_cast<Index>(c));
  }
  for (Index level = 1; !frontier_.empty(); ++level) {
    next_level(bodies, list, level);
    parallel::for_each(threads, frontier_.size(), grain, [&](std::size_t f) {
      const Index c = frontier_[f];
      const Index point = at(contacts.point, c);
      WeightedEstimate estimate;
      for (const Index edge : bodies.point_edges()[point]) {
        const Index other = list.find(bodies.other_end(edge, point), at(contacts.body, c));
        if (other < 0 || at(level_, other) == unreached || at(level_, other) >= level) continue;
        const Vec3 offset = at(positions, at(contacts.point, other)) - at(positions, point);
        estimate.add(offset, dot(offset, at(contacts.direction, other)) + at(contacts.depth, other),
                     at(contacts.direction, other));
      }
      if (estimate.usable()) {
        at(contacts.depth, c) = estimate.depth();
        at(contacts.direction, c) = estimate.direction();
      } else {
        take_nearest_surface(bodies, positions, contacts, static_cast<std::size_t>(c));
      }
    });
  }
}

}  // namespace palpate

#include "contact/cluster_queue.hpp"

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {

bool ClusterQueue::in(const InterestRegion& region, const Clusters& all, const Cluster& cluster,
                      std::span<const Vec3> positions) {
  const std::span<const Index> points = all.points_of(cluster);
  return std::ranges::any_of(points, [&](Index point) { return region.contains(at(positions, point)); });
}

void ClusterQueue::resize(std::size_t size) {
  resize_with_room(number_, size);
  resize_with_room(ordered_, size);
  assign_with_room(answers_, size, std::uint8_t{0});
}

std::size_t ClusterQueue::close(std::span<std::uint8_t> late_bodies) {
  std::size_t late = 0;
  for (std::size_t i = 0; i < answers_.size(); ++i) {
    std::uint8_t& state = states_[number_[i]];
    if ((answers_[i] & asked) == 0) {
      at(late_bodies, ordered_[i].body) = 1;
      ++late;
      if ((state & age_bits) < age_bits) ++state;
      continue;
    }
    state = static_cast<std::uint8_t>(((answers_[i] & near) != 0 ? state_near : 0) |
                                      ((answers_[i] & found) != 0 ? state_found : 0));
  }
  return late;
}

}  // namespace palpate

#include "contact/lost_contacts.hpp"

#include <algorithm>
#include <utility>

#include "mesh/grouped.hpp"
#include "room.hpp"

namespace palpate {

LostContacts::LostContacts(const SurfaceClusters& surface, const Bodies& bodies)
    : is_lost_(surface.clusters.clusters.size()) {
  const Clusters& all = surface.clusters;
  clusters_of_point_ = grouped(all.clusters.size(), bodies.points_rest().size(),
                               [&](std::size_t c) { return all.points_of(all.clusters[c]); });
}

void LostContacts::follow(const Bodies& bodies, const ContactTable& contacts) {
  const std::vector<Index>& points = contacts.contacts().point;
  const std::vector<Index>& in = contacts.contacts().body;
  if (!bodies_.empty()) std::ranges::fill(is_lost_, std::uint8_t{0});
  bodies_.clear();
  for (std::size_t was = 0, now = 0; was < points_.size(); ++was) {
    const std::pair key(points_[was], in_[was]);
    while (now < points.size() && std::pair(points[now], in[now]) < key) ++now;
    if (now < points.size() && std::pair(points[now], in[now]) == key) continue;
    const IndexPair pair = std::minmax(at(bodies.body_of_point(), key.first), key.second);
    if (bodies_.empty() || bodies_.back() != pair) {
      make_room(bodies_, bodies_.size() + 1);
      bodies_.push_back(pair);
    }
    for (const Index cluster : clusters_of_point_[key.first]) at(is_lost_, cluster) = 1;
  }
  std::ranges::sort(bodies_);
  bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
  make_room(points_, points.size());
  make_room(in_, in.size());
  points_.assign(points.begin(), points.end());
  in_.assign(in.begin(), in.end());
}

}  // namespace palpate

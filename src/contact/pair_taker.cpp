#include "contact/pair_taker.hpp"

#include <algorithm>
#include <bit>

#include "contact/layers.hpp"
#include "geometry/predicates.hpp"

namespace palpate {

bool PairTaker::take(const Cluster& cluster, Index point, std::uint32_t primitives) {
  const Bodies& bodies = context_.bodies;
  const PairFilter& may_touch = context_.may_touch;
  // Points of the tet's own body are no candidates, except with self-collision.
  const bool own = at(may_touch.self_collision, cluster.body) != 0 &&
                   at(bodies.bodies(), cluster.body).points.contains(point);
  if (!own && !may_touch.ignored_pairs.empty() &&
      may_touch.ignores(at(bodies.body_of_point(), point), cluster.body))
    return false;
  const Index* const tets = context_.clusters.primitives.data() + cluster.first;
  const std::size_t before = found_.size();
  const std::uint32_t sure = primitives >> 16;
  for (std::uint32_t left = primitives & 0xFFFFU; left != 0; left &= left - 1) {
    const int lane = std::countr_zero(left);
    const PointInTet pair{point, tets[lane]};
    if ((sure >> lane & 1) == 0 && !is_inside(pair)) continue;
    if (own && is_folded(pair, cluster.body)) continue;
    found_.push_back(pair);
  }
  if (!own && !may_touch.tied_points.empty()) leave_out_tied(cluster.body, before);
  return found_.size() > before;
}

/// Removes pairs of one point and tets of a body that a tie holds together.
/// \param first  of these pairs
void PairTaker::leave_out_tied(Index body, std::size_t first) {
  const Bodies& bodies = context_.bodies;
  const auto are_tied = [&](const PointInTet& pair) {
    return context_.may_touch.are_tied(at(bodies.body_of_point(), pair.point), std::array{pair.point}, body,
                                       at(bodies.tets(), pair.tet));
  };
  found_.erase(std::remove_if(found_.begin() + static_cast<std::ptrdiff_t>(first), found_.end(), are_tied),
               found_.end());
}

bool PairTaker::is_inside(const PointInTet& pair) const {
  const std::span<const Vec3> x = context_.positions;
  const Tet& tet = at(context_.bodies.tets(), pair.tet);
  return point_in_tet(at(x, pair.point), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3]));
}

bool PairTaker::is_folded(const PointInTet& pair, Index body) {
  if (at(context_.upright, body) != 0 || !is_fold(context_.bodies, context_.positions, pair.point, pair.tet))
    return false;
  ++tally_.folded_pairs;
  return true;
}

}  // namespace palpate

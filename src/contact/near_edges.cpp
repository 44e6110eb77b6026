#include "contact/near_edges.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace palpate {

EdgeBlocks::EdgeBlocks(const SurfaceClusters& surface, const Bodies& bodies) {
  for (Index c = 0; c < std::ssize(surface.clusters.clusters); ++c) {
    const std::span<const Index> points = surface.clusters.points_of(at(surface.clusters.clusters, c));
    const Index begin = at(surface.edges.begin, c);
    for (Index e = begin; e < at(surface.edges.begin, c + 1); ++e) {
      const auto lane = static_cast<std::size_t>(e - begin) % Cluster::most_primitives;
      if (lane == 0) places_.emplace_back();
      const Edge& ends = at(bodies.edges(), at(surface.edges.values, e));
      for (std::size_t i = 0; i < 2; ++i) {
        const auto place = std::ranges::lower_bound(points, ends[i]) - points.begin();
        places_.back()[i][lane] = static_cast<std::uint8_t>(place);
      }
    }
    begin_.push_back(static_cast<Index>(places_.size()));
  }
}

/// Reads the points of two clusters; those of the first one only if it is another one than before.
void FacingClusters::face(Index first, Index second) {
  const Box& a = at(frame_.boxes, first);
  const Box& b = at(frame_.boxes, second);
  if (clusters_[0] != first) {
    clusters_[0] = first;
    origin_ = 0.5 * (a.lower + a.upper);
    read_points(0);
  }
  clusters_[1] = second;
  read_points(1);
  const std::vector<Cluster>& clusters = frame_.surface.clusters.clusters;
  of_one_body_ = at(clusters, first).body == at(clusters, second).body;
  // No coordinate is larger than `extent`.
  const double extent = std::max(largest({a.lower - origin_, a.upper - origin_}),
                                 largest({b.lower - origin_, b.upper - origin_}));
  constexpr double rounding = 4e-6;
  constexpr double of_underflow = std::numeric_limits<float>::min();
  within_ = static_cast<float>((1.0 + 1e-6) * (margin_ + rounding * extent) / frame_.unit + of_underflow);
}

void FacingClusters::read_points(std::size_t side) {
  const Clusters& clusters = frame_.surface.clusters;
  simd::read_points(frame_.positions.data(), clusters.points_of(at(clusters.clusters, clusters_[side])),
                    origin_, 1.0 / frame_.unit, points_[side]);
}

/// Finds the triangles of each cluster at the points of the other one.
void FacingClusters::find_common_points() {
  const Clusters& all = frame_.surface.clusters;
  const Cluster& first = at(all.clusters, clusters_[0]);
  const Cluster& second = at(all.clusters, clusters_[1]);
  const std::span<const Index> of_first = all.points_of(first);
  const std::span<const Index> of_second = all.points_of(second);
  const auto triangles_at = [&](const Cluster& cluster, std::size_t point) {
    return all.at_point[static_cast<std::size_t>(cluster.first_point) + point];
  };
  at_point_ = {};
  for (std::size_t i = 0, j = 0; i < of_first.size() && j < of_second.size();) {
    const Index p = of_first[i];
    const Index q = of_second[j];
    if (p == q) {
      at_point_[0][i] = triangles_at(second, j);
      at_point_[1][j] = triangles_at(first, i);
    }
    i += p <= q ? 1 : 0;
    j += q <= p ? 1 : 0;
  }
}

/// Finds where the two surfaces can be within the margin; false where that is nowhere.
bool FacingClusters::find_common_part() {
  const Box& a = at(frame_.boxes, clusters_[0]);
  const Box& b = at(frame_.boxes, clusters_[1]);
  const double scale = 1.0 / frame_.unit;
  // Half of the margin for each of both boxes, and half for the primitive that must meet their common part.
  const auto more = static_cast<double>(within_);
  const Box common = common_part(a, b);
  const Vec3 lower = scale * (common.lower - origin_) - Vec3{more, more, more};
  const Vec3 upper = scale * (common.upper - origin_) + Vec3{more, more, more};
  const auto in_float = [](const Vec3& x) {
    return std::array{static_cast<float>(x.x), static_cast<float>(x.y), static_cast<float>(x.z)};
  };
  around_ = {in_float(lower), in_float(upper)};
  return lower.x <= upper.x && lower.y <= upper.y && lower.z <= upper.z;
}

/// Places the triangles that face the edges of a side; returns those in the common part of both boxes.
std::uint32_t FacingClusters::place_triangles(std::size_t side) {
  const Cluster& cluster = at(frame_.surface.clusters.clusters, clusters_[1 - side]);
  const std::uint32_t facing =
      simd::place_meeting(points_[1 - side], cluster, around_, triangles_, of_facing_) &
      ((1U << cluster.size) - 1U);
  const float more = (1.0F + 1e-6F) * within_;
  for (std::size_t k = 0; k < 3; ++k) {
    of_facing_.lower[k] = std::max(of_facing_.lower[k] - more, around_.lower[k]);
    of_facing_.upper[k] = std::min(of_facing_.upper[k] + more, around_.upper[k]);
  }
  return facing;
}

/// Places a block of edges; returns those that meet the box of the facing triangles.
std::uint32_t FacingClusters::place_edges(std::size_t side, std::size_t block) {
  const Index cluster = clusters_[side];
  const Rows& edges = frame_.surface.edges;
  const auto size = static_cast<std::size_t>(at(edges.begin, cluster + 1) - at(edges.begin, cluster));
  const std::size_t here = std::min(lanes, size - lanes * block);
  return simd::place_meeting(points_[side], frame_.blocks.of(cluster)[block], of_facing_, segments_) &
         ((1U << here) - 1U);
}

/// Leaves out triangles with a point of the edge.
void FacingClusters::choose_triangles(std::size_t side, std::size_t block, std::uint32_t facing) {
  wanted_.fill(static_cast<std::uint16_t>(facing));
  if (!of_one_body_) return;
  const simd::CornerPlaces<2>& ends = frame_.blocks.of(clusters_[side])[block];
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const unsigned common = at_point_[side][ends[0][lane]] | at_point_[side][ends[1][lane]];
    wanted_[lane] = static_cast<std::uint16_t>(facing & ~common);
  }
}

void FacingClusters::list(Index first, Index second, double margin, std::vector<NearEdge>& found) {
  margin_ = margin;
  face(first, second);
  if (!find_common_part()) return;
  if (of_one_body_) find_common_points();
  const std::size_t sides = first == second ? 1 : 2;
  for (std::size_t side = 0; side < sides; ++side) list_side(side, found);
  test_waiting(found);
}

void FacingClusters::list_side(std::size_t side, std::vector<NearEdge>& found) {
  const std::uint32_t facing = place_triangles(side);
  if (facing == 0) return;
  const Clusters& all = frame_.surface.clusters;
  const Index* const triangles = all.primitives_of(at(all.clusters, clusters_[1 - side])).data();
  const Index* const edges = frame_.surface.edges[clusters_[side]].data();
  const std::size_t blocks = frame_.blocks.of(clusters_[side]).size();
  for (std::size_t block = 0; block < blocks; ++block) {
    const std::uint32_t here = place_edges(side, block);
    if (here == 0) continue;
    choose_triangles(side, block, facing);
    std::uint32_t left = simd::keep_within(within_, segments_, here, triangles_, wanted_);
    for (; left != 0; left &= left - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(left));
      const Index edge = edges[lanes * block + lane];
      if (!waiting_.has_room(lanes)) test_waiting(found);
      for (std::uint32_t near = wanted_[lane]; near != 0; near &= near - 1)
        waiting_.add(edge, triangles[static_cast<std::size_t>(std::countr_zero(near))]);
    }
  }
}

void FacingClusters::test_waiting(std::vector<NearEdge>& found) {
  const auto margin = static_cast<float>((1.0 + 1e-6) * margin_);
  waiting_.test([&](std::size_t, const EdgeTriangle& pair, float gap) {
    if (!(gap > margin)) found.push_back({pair, std::max(0.0F, gap)});
  });
}

}  // namespace palpate

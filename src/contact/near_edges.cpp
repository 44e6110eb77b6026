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
  if (of_one_body_) find_common_points();
  placed_ = placed_block_ = none;
  // No coordinate is larger than `extent`. In units in its last place, a distance along a direction has an
  // error of at most 35 by its two projections and 20 by its division and root.
  const double extent = std::max(largest({a.lower - origin_, a.upper - origin_}),
                                 largest({b.lower - origin_, b.upper - origin_}));
  const double rounding = 4e-6 * extent;
  constexpr float of_underflow = std::numeric_limits<float>::min();
  rounding_ = static_cast<float>(rounding / frame_.unit) + of_underflow;
}

void FacingClusters::read_points(std::size_t side) {
  const Clusters& clusters = frame_.surface.clusters;
  const double scale = 1.0 / frame_.unit;
  simd::LocalPoints& local = points_[side];
  std::size_t i = 0;
  for (const Index p : clusters.points_of(at(clusters.clusters, clusters_[side]))) {
    const Vec3 x = scale * (at(frame_.positions, p) - origin_);
    local.x[i] = static_cast<float>(x.x);
    local.y[i] = static_cast<float>(x.y);
    local.z[i] = static_cast<float>(x.z);
    ++i;
  }
}

/// Finds the triangles of each cluster at the points of the other one.
void FacingClusters::find_common_points() {
  const Clusters& all = frame_.surface.clusters;
  for (std::size_t side = 0; side < 2; ++side) {
    const Cluster& other = at(all.clusters, clusters_[1 - side]);
    const std::span<const Index> others = all.points_of(other);
    const std::span<const std::uint16_t> triangles =
        std::span(all.at_point).subspan(static_cast<std::size_t>(other.first_point), other.points);
    std::size_t j = 0;
    std::size_t i = 0;
    for (const Index p : all.points_of(at(all.clusters, clusters_[side]))) {
      while (j < others.size() && others[j] < p) ++j;
      at_point_[side][i++] = j < others.size() && others[j] == p ? triangles[j] : std::uint16_t{0};
    }
  }
}

/// Finds where the two surfaces can be within the margin; false where that is nowhere.
bool FacingClusters::find_common_part(double margin) {
  const Box& a = at(frame_.boxes, clusters_[0]);
  const Box& b = at(frame_.boxes, clusters_[1]);
  const double scale = 1.0 / frame_.unit;
  margin_ = static_cast<float>(scale * margin) * (1.0F + 1e-6F);
  // Half of the margin for each of both boxes, and half for the primitive that must meet their common part.
  const double more = static_cast<double>(margin_) + static_cast<double>(rounding_);
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
  placed_ = side;
  placed_block_ = none;
  const Cluster& cluster = at(frame_.surface.clusters.clusters, clusters_[1 - side]);
  const std::uint32_t facing =
      simd::place_meeting(points_[1 - side], cluster, around_, triangles_, of_facing_) &
      ((1U << cluster.size) - 1U);
  const float more = (1.0F + 1e-6F) * (margin_ + rounding_);
  for (std::size_t k = 0; k < 3; ++k) {
    of_facing_.lower[k] = std::max(of_facing_.lower[k] - more, around_.lower[k]);
    of_facing_.upper[k] = std::min(of_facing_.upper[k] + more, around_.upper[k]);
  }
  return facing;
}

/// Places a block of edges; returns those that meet a box.
std::uint32_t FacingClusters::place_edges(std::size_t side, std::size_t block, const simd::FloatBox& box) {
  placed_block_ = block;
  const Index cluster = clusters_[side];
  const Rows& edges = frame_.surface.edges;
  const auto size = static_cast<std::size_t>(at(edges.begin, cluster + 1) - at(edges.begin, cluster));
  const std::size_t here = std::min(lanes, size - lanes * block);
  return simd::place_meeting(points_[side], frame_.blocks.of(cluster)[block], box, segments_) &
         ((1U << here) - 1U);
}

void FacingClusters::test(std::size_t side, std::size_t block, std::size_t lane, std::uint32_t facing,
                          std::vector<NearEdge>& found) const {
  if (of_one_body_) {
    const simd::CornerPlaces<2>& ends = frame_.blocks.of(clusters_[side])[block];
    facing &= ~std::uint32_t{at_point_[side][ends[0][lane]]} & ~std::uint32_t{at_point_[side][ends[1][lane]]};
    if (facing == 0) return;
  }
  const simd::NearTriangles near =
      simd::find_near_triangles(triangles_, facing, segments_, lane, margin_, rounding_);
  if (near.near != 0) found.push_back(edge_of(side, block, lane, near));
}

NearEdge FacingClusters::edge_of(std::size_t side, std::size_t block, std::size_t lane,
                                 const simd::NearTriangles& near) const {
  constexpr double down = 1.0 - 1e-6;  // for the rounding to float
  const auto apart = static_cast<float>(down * frame_.unit * static_cast<double>(near.apart));
  return {.side = static_cast<std::uint8_t>(side),
          .place = static_cast<std::uint8_t>(lanes * block + lane),
          .near = static_cast<std::uint16_t>(near.near),
          .touching = static_cast<std::uint16_t>(near.touching),
          .apart = near.touching == 0 ? apart : 0.0F};
}

void FacingClusters::test_again(NearEdge& edge) {
  const std::size_t side = edge.side;
  const std::size_t block = edge.place / lanes;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  if (placed_ != side || placed_block_ != block) {
    around_ = {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    if (placed_ != side) place_triangles(side);
    place_edges(side, block, around_);
  }
  const std::size_t lane = edge.place % lanes;
  constexpr float any = std::numeric_limits<float>::max();
  edge = edge_of(side, block, lane,
                 simd::find_near_triangles(triangles_, edge.near, segments_, lane, any, rounding_));
}

}  // namespace palpate

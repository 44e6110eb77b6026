#include "contact/cluster_motions.hpp"

#include <algorithm>
#include <array>

#include "geometry/vector.hpp"

namespace palpate {
namespace {

constexpr std::size_t clusters_of_chunk = 64;

Box box_of(const simd::PointBox& box) {
  return {{box.lower[0], box.lower[1], box.lower[2]}, {box.upper[0], box.upper[1], box.upper[2]}};
}

/// The displacement t + w x p.
simd::LinearMotion motion_of(const Vec3& t, const Vec3& w) {
  return {{{0.0, w.z, -w.y, 0.0}, {-w.z, 0.0, w.x, 0.0}, {w.y, -w.x, 0.0, 0.0}, {t.x, t.y, t.z, 0.0}}};
}

/// The solution of the system with these rows; zero if there is none.
Vec3 solution(const std::array<Vec3, 3>& rows, const Vec3& right) {
  const Vec3 yz = cross(rows[1], rows[2]);
  const Vec3 sum = right.x * yz + right.y * cross(rows[2], rows[0]) + right.z * cross(rows[0], rows[1]);
  const Vec3 x = (1.0 / dot(rows[0], yz)) * sum;
  return is_finite(x) ? x : Vec3{};
}

}  // namespace

/// The motion of a rigid body that is nearest to that of some points: one of each cluster.
simd::LinearMotion ClusterMotions::common_motion(std::span<const Vec3> positions, Index body) const {
  const Clusters& clusters = surface_.clusters;
  const Range range = at(surface_.of_body, body);
  const auto for_each_sample = [&](auto&& take) {
    for (Index c = range.begin; c < range.end; ++c) {
      const Index p = clusters.points_of(at(clusters.clusters, c)).front();
      take(at(last_, p), at(positions, p) - at(last_, p));
    }
  };
  Vec3 middle;
  Vec3 shift;
  for_each_sample([&](const Vec3& x, const Vec3& d) {
    middle += x;
    shift += d;
  });
  const double weight = 1.0 / std::max(1.0, static_cast<double>(range.size()));
  middle = weight * middle;
  shift = weight * shift;
  std::array<Vec3, 3> inertia{};
  Vec3 turn;
  for_each_sample([&](const Vec3& x, const Vec3& d) {
    const Vec3 r = x - middle;
    const double square = dot(r, r);
    inertia[0] += Vec3{square, 0.0, 0.0} - r.x * r;
    inertia[1] += Vec3{0.0, square, 0.0} - r.y * r;
    inertia[2] += Vec3{0.0, 0.0, square} - r.z * r;
    turn += cross(r, d - shift);
  });
  const Vec3 w = solution(inertia, turn);
  return motion_of(shift - cross(w, middle), w);
}

void ClusterMotions::follow_cluster(std::span<const Vec3> positions, std::size_t cluster) {
  const Cluster& of = surface_.clusters.clusters[cluster];
  const BodyMotion& body = at(bodies_, of.body);
  const simd::LinearMotion* const common = body.may_touch_itself ? &body.common : nullptr;
  simd::PointBoxes boxes;
  simd::find_boxes(positions.data(), last_.data(), surface_.clusters.points_of(of), common, boxes);
  boxes_[cluster] = box_of(boxes.places);
  Motion& motion = motions_[cluster];
  motion.displacements = grown(box_of(boxes.displacements), 0.0);
  if (common == nullptr) return;
  // A coordinate of a remainder is computed in seven operations, none with a result above this.
  const double displaced = largest(motion.displacements);
  const double place = largest(boxes_[cluster]) + displaced;
  double size = displaced;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& [x, y, z, none] = (*common)[k];
    size += (k < 3 ? place : 1.0) * std::max({std::abs(x), std::abs(y), std::abs(z)});
  }
  constexpr double rounding = 1e-15;
  motion.remainders = grown(box_of(boxes.remainders), rounding * size);
}

void ClusterMotions::follow(const parallel::Threads& threads, std::span<const Vec3> positions,
                            const PairFilter& may_touch) {
  if (last_.empty()) last_.assign(positions.begin(), positions.end());
  for (Index b = 0; b < std::ssize(bodies_); ++b) {
    BodyMotion& body = at(bodies_, b);
    body = {};
    body.may_touch_itself = may_touch.itself(b);
    if (body.may_touch_itself) body.common = common_motion(positions, b);
  }
  parallel::for_each(threads, boxes_.size(), clusters_of_chunk,
                     [&](std::size_t c) { follow_cluster(positions, c); });
  std::ranges::copy(positions, last_.begin());
  largest_side_ = 0.0;
  for (std::size_t c = 0; c < boxes_.size(); ++c) {
    BodyMotion& body = at(bodies_, surface_.clusters.clusters[c].body);
    body.box.extend(boxes_[c]);
    body.motion.displacements.extend(motions_[c].displacements);
    if (body.may_touch_itself) body.motion.remainders.extend(motions_[c].remainders);
    largest_side_ = std::max(largest_side_, largest({{}, boxes_[c].upper - boxes_[c].lower}));
  }
}

}  // namespace palpate

#include "contact/cluster_motions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "geometry/vector.hpp"

namespace palpate {
namespace {

constexpr Index clusters_of_piece = 64;
/// Points from which the common motion of a body is found.
constexpr Index most_samples = 64;

Box box_of(const simd::PlaceBox& box) {
  return {box.lower, box.upper};
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

/// Bound of the errors of displacements of a linear motion at points of a box: each coordinate is computed in
/// seven operations.
double error_of(const simd::LinearMotion& motion, const Box& box) {
  const double place = largest(box);
  double size = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& [x, y, z, none] = motion[k];
    size += (k < 3 ? place : 1.0) * std::max({std::abs(x), std::abs(y), std::abs(z)});
  }
  constexpr double rounding = 1e-15;
  return rounding * size;
}

}  // namespace

ClusterMotions::ClusterMotions(const SurfaceClusters& surface, const Bodies& bodies)
    : surface_(surface),
      boxes_(surface.clusters.clusters.size()),
      displacements_(boxes_.size()),
      remainders_(boxes_.size()),
      bodies_(bodies.bodies().size()) {
  for (Index body = 0; body < std::ssize(surface.of_body); ++body) {
    at(bodies_, body).points = at(bodies.bodies(), body).points;
    const Range& range = at(surface.of_body, body);
    for (Index begin = range.begin; begin < range.end; begin += clusters_of_piece)
      pieces_.push_back({.clusters = {begin, std::min(range.end, begin + clusters_of_piece)}, .body = body});
  }
}

/// The motion of a rigid body that is nearest to that of some points: one of each of some clusters.
simd::LinearMotion ClusterMotions::common_motion(std::span<const Vec3> positions, Index body) const {
  const Clusters& clusters = surface_.clusters;
  const Range range = at(surface_.of_body, body);
  const Index stride = 1 + range.size() / most_samples;
  const auto for_each_sample = [&](auto&& take) {
    for (Index c = range.begin; c < range.end; c += stride) {
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
  const Index samples = std::max(Index{1}, (range.size() + stride - 1) / stride);
  const double weight = 1.0 / static_cast<double>(samples);
  middle = weight * middle;
  shift = weight * shift;
  std::array<Vec3, 3> inertia{};
  Vec3 moment;
  for_each_sample([&](const Vec3& x, const Vec3& d) {
    const Vec3 r = x - middle;
    const double square = dot(r, r);
    inertia[0] += Vec3{square, 0.0, 0.0} - r.x * r;
    inertia[1] += Vec3{0.0, square, 0.0} - r.y * r;
    inertia[2] += Vec3{0.0, 0.0, square} - r.z * r;
    moment += cross(r, d - shift);
  });
  const Vec3 w = solution(inertia, moment);
  return motion_of(shift - cross(w, middle), w);
}

void ClusterMotions::follow(std::span<const Vec3> positions, Piece& piece) {
  const BodyMotion& body = at(bodies_, piece.body);
  const auto begin = static_cast<std::size_t>(piece.clusters.begin);
  const auto size = static_cast<std::size_t>(piece.clusters.size());
  static_assert(sizeof(Box) == 6 * sizeof(double));
  const simd::FollowedPoints all =
      simd::follow(positions.data(), last_.data(), surface_.clusters.points.data(),
                   std::span(surface_.clusters.clusters).subspan(begin, size),
                   body.may_touch_itself ? &body.common : nullptr, body.error,
                   {&boxes_[begin].lower.x, &displacements_[begin], &remainders_[begin]});
  piece.box = box_of(all.places);
  piece.motion.displacements = grown(box_of(all.displacements), 0.0);
  piece.largest_side = std::max({all.sides.x, all.sides.y, all.sides.z});
  if (!body.may_touch_itself) return;
  constexpr double rounding = 1e-15;
  piece.motion.remainders =
      grown(box_of(all.remainders), body.error + rounding * largest(piece.motion.displacements));
}

/// Finds whether a body has moved, and its common motion.
void ClusterMotions::begin(std::span<const Vec3> positions, Index number, bool may_touch_itself) {
  BodyMotion& body = at(bodies_, number);
  const auto first = static_cast<std::size_t>(body.points.begin);
  const auto size = static_cast<std::size_t>(body.points.size());
  // A body that was followed without a motion is not followed again until it moves.
  const bool was_still = body.is_still && body.may_touch_itself == may_touch_itself;
  body.is_still = std::memcmp(&positions[first], &last_[first], size * sizeof(Vec3)) == 0;
  body.rests = was_still && body.is_still;
  body.may_touch_itself = may_touch_itself;
  if (body.rests || !may_touch_itself) return;
  body.common = common_motion(positions, number);
  body.error = body.is_still ? 0.0 : error_of(body.common, body.box);
}

/// The boxes and motions of all pieces of each body.
void ClusterMotions::join_pieces() {
  for (BodyMotion& body : bodies_) {
    if (body.rests) continue;
    body.box = {};
    body.motion = {};
  }
  largest_side_ = 0.0;
  for (const Piece& piece : pieces_) {
    largest_side_ = std::max(largest_side_, piece.largest_side);
    BodyMotion& body = at(bodies_, piece.body);
    if (body.rests) continue;
    body.box.extend(piece.box);
    body.motion.displacements.extend(piece.motion.displacements);
    if (body.may_touch_itself) body.motion.remainders.extend(piece.motion.remainders);
  }
}

void ClusterMotions::follow(const parallel::Threads& threads, std::span<const Vec3> positions,
                            const PairFilter& may_touch) {
  if (last_.empty()) last_.assign(positions.begin(), positions.end());
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t b) {
    begin(positions, static_cast<Index>(b), may_touch.itself(static_cast<Index>(b)));
  });
  parallel::for_each(threads, pieces_.size(), 1, [&](std::size_t i) {
    if (!at(bodies_, pieces_[i].body).rests) follow(positions, pieces_[i]);
  });
  parallel::for_each(threads, bodies_.size(), 1, [&](std::size_t b) {
    const BodyMotion& body = bodies_[b];
    if (body.is_still) return;
    const auto own = positions.subspan(static_cast<std::size_t>(body.points.begin),
                                       static_cast<std::size_t>(body.points.size()));
    std::ranges::copy(own, last_.begin() + body.points.begin);
  });
  join_pieces();
}

}  // namespace palpate

#include "sim/kept_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t kept_grain = 256;
/// Largest change of a weight of the foot point; if it moves further, the contact is dropped.
constexpr double farthest_slide = 0.25;

std::pair<Index, Index> key_of(const KeptContact& contact) {
  return {contact.point, contact.body};
}

/// Computes the gradients of the weights of a tet with these corners. Returns false if the tet is flat.
bool find_gradients(const std::array<Vec3, 4>& corners, std::array<Vec3, 4>& gradients) {
  const Vec3 a = corners[1] - corners[0];
  const Vec3 b = corners[2] - corners[0];
  const Vec3 c = corners[3] - corners[0];
  const double volume = dot(a, cross(b, c));
  if (volume == 0.0) return false;
  gradients[1] = (1.0 / volume) * cross(b, c);
  gradients[2] = (1.0 / volume) * cross(c, a);
  gradients[3] = (1.0 / volume) * cross(a, b);
  gradients[0] = -1.0 * (gradients[1] + gradients[2] + gradients[3]);
  return true;
}

struct StepMotion {
  const RimFalloff& rims;
  std::span<const Vec3> positions;
  std::span<const Vec3> velocities;
  double time_step = 0.0;
  double fall = 0.0;
};

/// Computes the position of the point relative to the plane. Returns false if it cannot touch within the
/// step.
bool place(const Bodies& bodies, const StepMotion& motion, NearContact& near) {
  const KeptContact& kept = near.kept;
  const Tet& tet = at(bodies.tets(), kept.tet);
  std::array<Vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = at(motion.positions, tet[i]);
  std::array<Vec3, 4> gradients;
  if (!find_gradients(corners, gradients)) return false;
  Vec3 steepest;
  for (std::size_t i = 0; i < 4; ++i) steepest += kept.distances[i] * gradients[i];
  const double slope = length(steepest);
  if (!(slope > 0.0)) return false;
  near.direction = (1.0 / slope) * steepest;
  const Vec3 from_corner = at(motion.positions, kept.point) - corners[0];
  near.gap = dot(near.direction, from_corner) + kept.distances[0] / slope;
  const Vec3 foot = from_corner - near.gap * near.direction;
  double slide = 0.0;
  Vec3 path;
  Vec3 velocity = at(motion.velocities, kept.point);
  for (std::size_t i = 0; i < 4; ++i) {
    near.weights[i] = dot(gradients[i], foot) + (i == 0 ? 1.0 : 0.0);
    slide = std::max(slide, std::abs(near.weights[i] - kept.foot[i]));
    path += (near.weights[i] - kept.foot[i]) * corners[i];
    velocity -= near.weights[i] * at(motion.velocities, tet[i]);
  }
  // If detection did not find the point in the body, it is not in contact even below the plane, because the
  // body ends before it.
  if (!(near.gap >= 0.0) || slide > farthest_slide) return false;
  const Index own = at(bodies.body_of_point(), kept.point);
  if (length(path) > motion.rims.reach(own)) return false;
  return near.gap <= motion.time_step * length(velocity) + motion.fall;
}

}  // namespace

KeptContact kept_contact(const Bodies& bodies, Index point, Index body, Index tet,
                         const std::array<double, 4>& weights, double depth, const Vec3& direction,
                         double stiffness, std::span<const Vec3> positions) {
  KeptContact kept{.point = point, .body = body, .tet = tet, .foot = weights, .stiffness = stiffness};
  const Tet& points = at(bodies.tets(), tet);
  std::array<Vec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) corners[i] = at(positions, points[i]);
  const Vec3 foot = at(positions, point) + depth * direction;
  for (std::size_t i = 0; i < 4; ++i) kept.distances[i] = dot(corners[i] - foot, direction);
  std::array<Vec3, 4> gradients;
  if (find_gradients(corners, gradients)) {
    for (std::size_t i = 0; i < 4; ++i) kept.foot[i] += depth * dot(gradients[i], direction);
  }
  return kept;
}

std::span<KeptContact> KeptContacts::add(std::size_t more) {
  const std::size_t first = next_.size();
  make_room(next_, first + more);
  next_.resize(first + more);
  return std::span(next_).subspan(first);
}

void KeptContacts::begin() {
  kept_.swap(next_);
  next_.clear();
  std::ranges::sort(kept_, {}, key_of);
}

std::span<const NearContact> KeptContacts::near(const parallel::Threads& threads, const Bodies& bodies,
                                                const RimFalloff& rims, const Contacts& contacts,
                                                std::span<const Vec3> positions,
                                                std::span<const Vec3> velocities, double time_step,
                                                double fall) {
  make_room(near_, kept_.size());
  near_.clear();
  std::size_t c = 0;
  for (const KeptContact& kept : kept_) {
    const std::pair key = key_of(kept);
    while (c < contacts.size() && std::pair(contacts.point[c], contacts.body[c]) < key) ++c;
    const bool is_there = c < contacts.size() && std::pair(contacts.point[c], contacts.body[c]) == key;
    if (!is_there) near_.emplace_back().kept = kept;
  }
  const StepMotion motion{rims, positions, velocities, time_step, fall};
  parallel::for_each(threads, near_.size(), kept_grain, [&](std::size_t i) {
    if (!place(bodies, motion, near_[i])) near_[i].kept.point = -1;
  });
  std::erase_if(near_, [](const NearContact& near) { return near.kept.point < 0; });
  return near_;
}

}  // namespace palpate

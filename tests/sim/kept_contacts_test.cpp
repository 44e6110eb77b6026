// Oracles: distances to a plane by hand, also for a rotated and stretched body.
#include "sim/kept_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "support/meshes.hpp"

namespace palpate {
namespace {

constexpr double time_step = 0.01;

/// One tet whose top is z = 0, and a tet above it whose lowest point is in contact.
struct Touching {
  Touching() {
    bodies.add("below", {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, -1}}, {{0, 2, 1, 3}}});
    bodies.add("above", {{{0.3, 0.3, -0.02}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}, {{0, 1, 2, 3}}});
    positions.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    velocities.resize(positions.size());
    const std::array<double, 4> weights{0.4 - 0.02 * 0.4, 0.3 - 0.02 * 0.3, 0.3 - 0.02 * 0.3, 0.02};
    contact = kept_contact(bodies, point, 0, 0, weights, 0.02, {0, 0, 1}, 100.0, positions);
  }
  std::vector<NearContact> near(double fall, const Contacts& contacts = {}) {
    KeptContacts kept;
    const RimFalloff rims(bodies);
    kept.add(1)[0] = contact;
    kept.begin();
    const auto found =
        kept.near(parallel::Threads(2), bodies, rims, contacts, positions, velocities, time_step, fall);
    return {found.begin(), found.end()};
  }
  static constexpr Index point = 4;
  Bodies bodies;
  std::vector<Vec3> positions;
  std::vector<Vec3> velocities;
  KeptContact contact;
};

TEST(KeptContacts, HaveTheGapOfALiftedPoint) {
  Touching scene;
  at(scene.positions, Touching::point) = {0.35, 0.3, 0.005};
  const auto near = scene.near(0.01);
  ASSERT_EQ(near.size(), 1U);
  EXPECT_NEAR(near[0].gap, 0.005, 1e-15);
  EXPECT_NEAR(length(near[0].direction - Vec3{0, 0, 1}), 0.0, 1e-15);
  EXPECT_EQ(near[0].kept.stiffness, 100.0);
  const std::array<double, 4> foot{0.35, 0.3, 0.35, 0.0};  // (0.35, 0.3, 0)
  for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(near[0].weights[i], foot[i], 1e-14);
}

TEST(KeptContacts, PlanesTurnAndStretchWithTheTissue) {
  Touching scene;
  at(scene.positions, Touching::point) = {0.35, 0.3, 0.005};
  // x' = M x + t, of both bodies: the plane z = 0 goes to the plane through t along M's first two columns.
  const std::array<Vec3, 3> columns{Vec3{0.6, 0.9, 0.1}, Vec3{-0.7, 0.8, 0.2}, Vec3{0.1, -0.3, 1.4}};
  const Vec3 moved{3, -2, 5};
  for (Vec3& p : scene.positions) p = moved + p.x * columns[0] + p.y * columns[1] + p.z * columns[2];
  const Vec3 normal = normalized(cross(columns[0], columns[1]));
  const double gap = dot(at(scene.positions, Touching::point) - moved, normal);
  const auto near = scene.near(0.1);
  ASSERT_EQ(near.size(), 1U);
  EXPECT_NEAR(near[0].gap, gap, 1e-14);
  EXPECT_NEAR(length(near[0].direction - normal), 0.0, 1e-14);
}

TEST(KeptContacts, AreThoseThatTheStepMayClose) {
  Touching scene;
  at(scene.positions, Touching::point) = {0.3, 0.3, 0.005};
  EXPECT_TRUE(scene.near(0.004).empty()) << "gravity does not bring it there";
  EXPECT_EQ(scene.near(0.006).size(), 1U);
  at(scene.velocities, Touching::point) = {0, 0, -0.6};  // 6 mm a step
  EXPECT_EQ(scene.near(0.0).size(), 1U);
}

TEST(KeptContacts, EndAtTheBorderOfTheBody) {
  Touching scene;
  at(scene.positions, Touching::point) = {0.6, 0.3, 0.001};
  EXPECT_TRUE(scene.near(0.01).empty()) << "0.3 along the face";
  at(scene.positions, Touching::point) = {0.3, 0.3, -0.001};
  EXPECT_TRUE(scene.near(0.01).empty()) << "below the plane, and yet not in the body";
}

TEST(KeptContacts, OfThisStepAreNotNear) {
  Touching scene;
  at(scene.positions, Touching::point) = {0.3, 0.3, 0.001};
  Contacts contacts;
  contacts.point = {Touching::point};
  contacts.body = {0};
  EXPECT_TRUE(scene.near(0.01, contacts).empty());
  contacts.body = {1};
  EXPECT_EQ(scene.near(0.01, contacts).size(), 1U) << "of another body";
}

TEST(KeptContacts, AreUnchangedByAFailedStep) {
  Touching scene;
  KeptContacts kept;
  kept.add(1)[0] = scene.contact;
  kept.begin();
  EXPECT_TRUE(kept.all().empty());
  std::ranges::fill(kept.add(2), scene.contact);
  kept.undo();
  ASSERT_EQ(kept.all().size(), 1U);
  EXPECT_EQ(kept.all().front().point, Touching::point);
}

}  // namespace
}  // namespace palpate

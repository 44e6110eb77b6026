// How far rotations are slowed down, by numbers that are easy to add up.
#include <cmath>
#include <gtest/gtest.h>
#include <optional>

#include "fem/energy_limit.hpp"

namespace palpate::fem {
namespace {

constexpr Index ball = 0;
constexpr Index other = 1;
constexpr Index floor_body = 2;

/// Two free bodies that had 5 J each, and a floor.
EnergyLimit begun() {
  EnergyLimit limit(3);
  limit.begin(ball, 5.0);
  limit.begin(other, 5.0);
  limit.begin(floor_body, std::nullopt);
  return limit;
}

/// A body goes down by 1 m against a force of 2 N, so the contact gives nothing.
EnergyLimit::Contact touch(Index body, Index support) {
  return {.bodies = {body, support},
          .free = {true, support != floor_body},
          .paths = {Vec3{0.0, 0.0, -1.0}, Vec3{}},
          .force = {0.0, 0.0, 2.0}};
}

/// The factor of the ball's rotation if its energy is `energy` at the end, of which 4 J are of rotation.
double factor_with(EnergyLimit& limit, double energy) {
  limit.mark_rotating(ball);
  if (!limit.find_groups()) return 1.0;
  limit.set_end(ball, energy, limit.given(ball), 4.0);
  if (limit.is_limited(other)) limit.set_end(other, 5.0, limit.given(other), 0.0);
  limit.settle();
  return limit.factor(ball);
}

TEST(EnergyLimit, TakesFromTheRotationWhatHasNoReason) {
  EnergyLimit limit = begun();
  limit.add(touch(ball, floor_body));
  EXPECT_DOUBLE_EQ(factor_with(limit, 6.0), std::sqrt(0.75));
  EXPECT_DOUBLE_EQ(limit.losses()[ball], 0.0);
}

TEST(EnergyLimit, WhatContactsTookMayComeBackForAWhile) {
  EnergyLimit limit = begun();
  limit.add(touch(ball, floor_body));
  EXPECT_EQ(factor_with(limit, 4.0), 1.0);
  EXPECT_DOUBLE_EQ(limit.losses()[ball], 1.0);
  limit.begin(ball, 4.0);
  limit.forget();
  limit.add(touch(ball, floor_body));
  EXPECT_EQ(factor_with(limit, 4.75), 1.0) << "0.9 J of the loss are left";
  EXPECT_NEAR(limit.losses()[ball], 0.15, 1e-12);
}

TEST(EnergyLimit, WorkOfAFloorThatMovesAndStoredEnergyAreReasons) {
  EnergyLimit limit = begun();
  EnergyLimit::Contact contact = touch(ball, floor_body);
  limit.add(contact);
  EXPECT_DOUBLE_EQ(limit.given(ball), 0.0);
  contact.paths[1] = {0.0, 0.0, -1.0};  // its coefficient is -1: the floor rises by 1 m
  limit.add(contact);
  EXPECT_DOUBLE_EQ(limit.given(ball), 2.0);
  limit = begun();
  contact = touch(ball, floor_body);
  contact.paths[0] = {0.0, 0.0, 1.0};  // the contact drives the body out
  contact.force_at_start = {0.0, 0.0, 6.0};
  limit.add(contact);
  EXPECT_DOUBLE_EQ(limit.given(ball), 4.0) << "the mean of both forces";
}

TEST(EnergyLimit, OnlyOfGroupsThatAreKnownAndTouchWhatIsNotFree) {
  EnergyLimit limit = begun();
  EXPECT_EQ(factor_with(limit, 6.0), 1.0) << "nothing touches it: its angular momentum stays";
  limit = begun();
  limit.add(touch(ball, other));
  EXPECT_EQ(factor_with(limit, 6.0), 1.0) << "free bodies touch each other";
  limit = begun();
  limit.add(touch(ball, other));
  limit.add(touch(other, floor_body));
  EXPECT_DOUBLE_EQ(factor_with(limit, 6.0), std::sqrt(0.75)) << "supported by the other one";
  limit = begun();
  limit.add(touch(ball, other));
  limit.add(touch(other, floor_body));
  limit.mark_unknown(other);
  EXPECT_EQ(factor_with(limit, 6.0), 1.0);
}

}  // namespace
}  // namespace palpate::fem

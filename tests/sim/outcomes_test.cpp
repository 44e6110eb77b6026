// Quantities of outcomes. Oracles: closed forms, prescribed rotations, and the weight of a block.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <string>

#include <palpate/error.hpp>
#include <palpate/outcomes.hpp>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate::test {
namespace {

constexpr double pi = std::numbers::pi;

std::vector<Vec3> turned(std::span<const Vec3> points, const Vec3& axis, double angle,
                         const Vec3& shift = {}) {
  std::vector<Vec3> result;
  for (const Vec3& p : points) result.push_back(rotated(p, axis, angle) + shift);
  return result;
}

/// A unit cube about the origin and another, at these places.
Bodies two_cubes(int cells = 3) {
  Bodies bodies;
  bodies.add("a", box_mesh({cells, cells, cells}, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
  bodies.add("b", box_mesh({2, 2, 2}, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}));
  return bodies;
}

TEST(Outcomes, VolumesOfACutCubeAreTheClosedForms) {
  const Bodies cubes = two_cubes();
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    const Vec3 axis = normalized(random.point(-1.0, 1.0));
    const double angle = 3.0 * random.point(0.0, 1.0).x;
    const Vec3 shift = random.point(-2.0, 2.0);
    const std::vector<Vec3> now = turned(cubes.points_rest(), axis, angle, shift);
    const auto beyond = [&](const Vec3& point, const Vec3& normal) {
      const std::vector<HalfSpace> one{
          {rotated(point, axis, angle) + shift, 7.0 * rotated(normal, axis, angle)}};
      return volume_in(cubes, 0, now, one);
    };
    EXPECT_NEAR(beyond({}, random.point(-1.0, 1.0)), 0.5, 1e-12) << "through the middle";
    const double t = 0.9 * random.point(0.0, 1.0).x + 0.05;
    EXPECT_NEAR(beyond({0.5 - t, 0.5, 0.5}, {1, 1, 1}), t * t * t / 6.0, 1e-12) << "a corner";
    EXPECT_NEAR(beyond({0.5 - t, 0.5, 0.0}, {1, 1, 0}), t * t / 2.0, 1e-12) << "an edge";
    EXPECT_NEAR(beyond({0.5 - t, 0.0, 0.0}, {1, 0, 0}), t, 1e-12) << "a slab";
    EXPECT_EQ(beyond({0.5, 0.0, 0.0}, {1, 0, 0}) < 1e-12, true) << "nothing";
    const std::vector<HalfSpace> octant{{shift, rotated({1, 0, 0}, axis, angle)},
                                        {shift, rotated({0, -1, 0}, axis, angle)},
                                        {shift, rotated({0, 0, 1}, axis, angle)}};
    EXPECT_NEAR(volume_in(cubes, 0, now, octant), 0.125, 1e-12);
  }
  EXPECT_NEAR(volume_in(cubes, 0, cubes.points_rest(), {}), 1.0, 1e-12);
}

TEST(Outcomes, VolumesWithinAnotherBodyAreTheClosedForms) {
  const Bodies cubes = two_cubes();
  std::vector<Vec3> now(cubes.points_rest().begin(), cubes.points_rest().end());
  const Range b = cubes.bodies()[1].points;
  const auto place_b = [&](const Vec3& axis, double angle, const Vec3& shift) {
    for (Index p = b.begin; p < b.end; ++p)
      at(now, p) = rotated(at(cubes.points_rest(), p), axis, angle) + shift;
  };
  place_b({0, 0, 1}, 0.0, {0.3, -0.2, 0.6});
  EXPECT_NEAR(volume_within(cubes, 0, 1, now, {}), 0.7 * 0.8 * 0.4, 1e-12);
  const std::vector<HalfSpace> upper{{{0.0, 0.0, 0.4}, {0, 0, 1}}};
  EXPECT_NEAR(volume_within(cubes, 0, 1, now, upper), 0.7 * 0.8 * 0.1, 1e-12);
  place_b({0, 0, 1}, pi / 4.0, {});
  EXPECT_NEAR(volume_within(cubes, 0, 1, now, {}), 2.0 * (std::sqrt(2.0) - 1.0), 1e-12) << "an octagon";
  place_b({0, 0, 1}, 0.0, {1.5, 0.0, 0.0});
  EXPECT_EQ(volume_within(cubes, 0, 1, now, {}), 0.0);
}

/// Surface triangles of a body with corners that all hold.
template <class Holds>
std::vector<Index> walls_of(const Bodies& bodies, Holds&& holds) {
  std::vector<Index> walls;
  for (Index t = 0; t < static_cast<Index>(bodies.triangles().size()); ++t) {
    const Triangle& corners = at(bodies.triangles(), t);
    if (std::ranges::all_of(corners, [&](Index p) { return holds(at(bodies.points_rest(), p)); }))
      walls.push_back(t);
  }
  return walls;
}

TEST(Outcomes, TheVolumeOfAHollowInABoxIsTheClosedForm) {
  TetMesh box = box_mesh({3, 3, 3}, {0, 0, 0}, {3, 3, 3});
  constexpr std::ptrdiff_t tets_of_cell = 6;
  const auto middle = box.tets.begin() + tets_of_cell * (1 + 3 * (1 + 3 * 1));
  box.tets.erase(middle, middle + tets_of_cell);
  Bodies bodies;
  bodies.add("hollow", box);
  const auto inside = [](double x) { return x > 0.5 && x < 2.5; };
  const Cavity hollow = cavity(
      bodies, walls_of(bodies, [&](const Vec3& p) { return inside(p.x) && inside(p.y) && inside(p.z); }));
  EXPECT_EQ(hollow.walls.size(), 12);
  EXPECT_TRUE(hollow.openings.empty());
  EXPECT_NEAR(volume_of(hollow, bodies, bodies.points_rest()), 1.0, 1e-12);
  std::vector<Vec3> now;
  for (const Vec3& p : bodies.points_rest())
    now.push_back({1.5 * p.x + 0.3 * p.y + 7.0, 0.8 * p.y, 1.1 * p.z});
  EXPECT_NEAR(volume_of(hollow, bodies, now), 1.5 * 0.8 * 1.1, 1e-12);
}

TEST(Outcomes, OpeningsOfACavityAreClosedByLids) {
  const Bodies cubes = two_cubes();
  const auto is_open = [](const std::array<Vec3, 3>& corners, double z) {
    return std::ranges::all_of(corners, [&](const Vec3& p) { return p.z == z; });
  };
  for (const bool both : {false, true}) {
    std::vector<Index> walls;
    for (const Index t : walls_of(cubes, [](const Vec3&) { return true; })) {
      if (t >= cubes.bodies()[0].triangles.end) continue;
      const Triangle& corners = at(cubes.triangles(), t);
      const std::array<Vec3, 3> places{at(cubes.points_rest(), corners[0]),
                                       at(cubes.points_rest(), corners[1]),
                                       at(cubes.points_rest(), corners[2])};
      if (!is_open(places, 0.5) && !(both && is_open(places, -0.5))) walls.push_back(t);
    }
    const Cavity cup = cavity(cubes, walls);
    EXPECT_EQ(cup.openings.size(), both ? 2 : 1);
    EXPECT_NEAR(volume_of(cup, cubes, cubes.points_rest()), 1.0, 1e-12);
    const auto now = turned(cubes.points_rest(), normalized({1, 2, 3}), 0.7, {10, 2, 3});
    EXPECT_NEAR(volume_of(cup, cubes, now), 1.0, 1e-11);
    std::vector<Vec3> narrow(cubes.points_rest().begin(), cubes.points_rest().end());
    for (Vec3& p : narrow) {
      const double scale = 0.7 - 0.6 * p.z;  // 1 at the bottom, 0.4 at the top
      p = {scale * p.x, scale * p.y, p.z};
    }
    EXPECT_NEAR(volume_of(cup, cubes, narrow), (1.0 + 0.4 + 0.16) / 3.0, 1e-12) << "a frustum";
  }
}

TEST(Outcomes, WallsWithoutACavityAreRefused) {
  const Bodies cubes = two_cubes();
  const auto refusal = [&](const std::vector<Index>& walls) {
    try {
      static_cast<void>(cavity(cubes, walls));
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(refusal({}), "cavity: walls: found no surface triangle, expected one or more");
  EXPECT_EQ(refusal({0, 1, 0}),
            "cavity: walls: found a triangle for the second time, expected each triangle once");
  EXPECT_EQ(refusal({0, 5000}), "cavity: walls: found a triangle out of range, expected surface triangles");
  EXPECT_EQ(
      refusal(walls_of(cubes, [](const Vec3& p) { return p.z == 0.5; })),
      "cavity: walls: found a part of a surface that encloses no volume, expected the walls of a cavity");
}

TEST(Outcomes, RotationsAreThosePrescribed) {
  const Bodies cubes = two_cubes();
  const std::vector<double> masses(cubes.points_rest().size(), 0.3);
  Random random(5);
  for (const double angle : {0.0, 1e-9, 1e-3, 0.5, 1.5, 3.0, 3.14159, pi}) {
    const Vec3 axis = normalized(random.point(-1.0, 1.0));
    const Vec3 found = rotation_of(cubes, 0, turned(cubes.points_rest(), axis, angle, {3, 2, 1}), masses);
    EXPECT_NEAR(length(found), angle, 1e-8);
    const double apart =
        std::min(length(found - angle * axis), angle == pi ? length(found + angle * axis) : 1e9);
    EXPECT_LT(apart, 1e-7) << angle;
  }
}

TEST(Outcomes, LandmarksGoWithTheirTet) {
  const Bodies cubes = two_cubes();
  const Vec3 place{0.21, -0.13, 0.44};
  const Landmark mark = landmark(cubes, 0, place);
  const Vec3 axis{1, 2, 3};
  const auto now = turned(cubes.points_rest(), normalized(axis), 0.7, {1, 2, 3});
  EXPECT_LT(length(place_of(cubes, mark, now) - (rotated(place, normalized(axis), 0.7) + Vec3{1, 2, 3})),
            1e-12);
  EXPECT_LT(
      length(place_of(cubes, landmark(cubes, 1, {0.5, 0.5, 0.5}), cubes.points_rest()) - Vec3{0.5, 0.5, 0.5}),
      1e-12)
      << "a corner";
  try {
    static_cast<void>(landmark(cubes, 0, {0.75, 0.0, 0.0}));
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(),
                 "landmark: found a position 0.25 outside of 'a', expected a position in the body at rest");
  }
}

TEST(Outcomes, DistancesOfCubesAreTheClosedForms) {
  const Bodies cubes = two_cubes(5);
  std::vector<Vec3> now(cubes.points_rest().begin(), cubes.points_rest().end());
  const Range b = cubes.bodies()[1].points;
  const auto distance_at = [&](auto&& place) {
    for (Index p = b.begin; p < b.end; ++p) at(now, p) = place(at(cubes.points_rest(), p));
    EXPECT_EQ(distance_of(cubes, 0, 1, now), distance_of(cubes, 1, 0, now));
    return distance_of(cubes, 0, 1, now);
  };
  EXPECT_NEAR(distance_at([](const Vec3& p) { return p + Vec3{0.3, 0.1, 1.25}; }), 0.25, 1e-12) << "faces";
  EXPECT_NEAR(distance_at([](const Vec3& p) {
                return p + Vec3{2.0, 3.0, 4.0};
              }),
              std::sqrt(1.0 + 4.0 + 9.0), 1e-12)
      << "corners";
  // An edge of one along x above an edge of the other along y: both turned by 45 degrees.
  const auto crossed = [](const Vec3& p) {
    return rotated(rotated(p, {1, 0, 0}, pi / 4.0), {0, 0, 1}, pi / 2.0) + Vec3{0.0, 0.0, 1.5};
  };
  const double high = std::sqrt(0.5);
  for (Index p = 0; p < b.begin; ++p) at(now, p) = rotated(at(cubes.points_rest(), p), {1, 0, 0}, pi / 4.0);
  EXPECT_NEAR(distance_at(crossed), 1.5 - 2.0 * high, 1e-12) << "edges";
}

TEST(Outcomes, ABlockOnAPlateTouchesWithItsWholeFace) {
  for (const int cells : {2, 5}) {  // the block is coarser than the plate, and finer
    Model model;
    model.bodies.add("plate", box_mesh({6, 6, 1}, {-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}));
    model.bodies.add("block", box_mesh({cells, cells, 2}, {-0.05, -0.04, 0.0}, {0.05, 0.04, 0.05}));
    model.materials = {{}, {.young_modulus = 1e5, .stiffness_damping = 0.01}};
    model.obstacles = {1, 0};
    Simulation simulation(std::move(model), {}, 2);
    EXPECT_EQ(contact_area(simulation, 0, 1), 0.0);
    for (int i = 0; i < 300 && !simulation.at_rest(); ++i) simulation.step();
    EXPECT_TRUE(simulation.at_rest());
    EXPECT_NEAR(contact_area(simulation, 1, 0), 0.1 * 0.08, 0.01 * 0.1 * 0.08);
    EXPECT_EQ(contact_area(simulation, 0, 1), contact_area(simulation, 1, 0));
  }
}

}  // namespace
}  // namespace palpate::test

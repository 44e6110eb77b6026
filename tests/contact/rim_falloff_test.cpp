// The cache of the rims near a contact must never change its scale, however bodies move: every scale is
// compared with that of a walk.
#include "contact/rim_falloff.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <utility>

#include "geometry/vector.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

/// Points anywhere in the tets of another body, with directions along the axes or anywhere.
struct Scene {
  explicit Scene(const TetMesh& mesh, std::uint64_t seed) : random(seed) {
    bodies.add("penetrated", mesh);
    bodies.add("points", test::box_mesh({6, 6, 6}, {-1, -1, -1}, {1, 1, 1}));
    positions.assign(bodies.points_rest().begin(), bodies.points_rest().end());
    const Range points = bodies.bodies()[1].points;
    for (Index p = points.begin; p < points.end; ++p) {
      const Index tet = random.integer(0, bodies.bodies()[0].tets.size() - 1);
      std::array<double, 4> weights{};
      double sum = 0.0;
      for (double& w : weights) sum += w = random.uniform(0.0, 1.0);
      Vec3 place;
      for (std::size_t i = 0; i < 4; ++i)
        place += (weights[i] / sum) * at(positions, at(bodies.tets(), tet)[i]);
      at(positions, p) = place;
      contacts.point.push_back(p);
      contacts.body.push_back(0);
      contacts.tet.push_back(tet);
      const Vec3 anywhere = normalized(random.point(-1.0, 1.0));
      contacts.direction.push_back(random.chance(0.3) ? anywhere : Vec3{0.0, 0.0, 1.0});
    }
  }
  /// Moves all points of a body by up to `most`, and all directions by up to `turn`.
  void move(std::size_t body, double most, double rotation) {
    const Range points = bodies.bodies()[body].points;
    for (Index p = points.begin; p < points.end; ++p) at(positions, p) += random.point(-most, most);
    for (Vec3& d : contacts.direction) d = normalized(d + random.point(-rotation, rotation));
  }
  test::Random random;
  Bodies bodies;
  std::vector<Vec3> positions;
  Contacts contacts;
};

/// How many contacts know that they are clear at the end.
int run(Scene& scene, int steps, double most, double rotation) {
  const parallel::Threads threads(2);
  RimFalloff rims(scene.bodies);
  ExitSearch search;
  RimCache cache;
  resize_columns(cache, scene.contacts.size());
  for (std::size_t c = 0; c < scene.contacts.size(); ++c) clear_row(cache, c);
  for (int step = 0; step < steps; ++step) {
    // Now and then one of the bodies leaps, or so few are in contact that none is compared.
    const bool leaps = step % 17 == 16;
    scene.move(static_cast<std::size_t>(step) % 2, leaps ? 0.1 : most, rotation);
    rims.begin(threads, scene.bodies, scene.positions, step % 29 == 28 ? 1 : scene.contacts.size());
    for (std::size_t c = 0; c < scene.contacts.size(); ++c) {
      const double walked =
          rims.scale(scene.bodies, scene.positions, at(scene.positions, scene.contacts.point[c]),
                     scene.contacts.tet[c], scene.contacts.direction[c], search);
      const double cached = rims.scale(scene.bodies, scene.positions, scene.contacts, c, search, cache);
      EXPECT_EQ(cached, walked) << "step " << step << ", contact " << c;
      if (cached != walked) return -1;
    }
  }
  int clear = 0;
  for (const std::uint8_t state : cache.state) clear += state == RimCache::clear ? 1 : 0;
  return clear;
}

/// Oracle: a slope that follows from the band of cosines in which sides fade in.
TEST(RimFalloff, OfFadingSidesIsContinuousInTheDirectionAndNotBelowThatOfSharpOnes) {
  Scene scene(test::box_mesh({3, 3, 3}, {-1, -1, -1}, {1, 1, 1}), 5);
  const RimFalloff rims(scene.bodies);
  ExitSearch search;
  constexpr double rotation = 1e-5;
  const double slope = rims.reach(0) / (0.15 * (rims.reach(0) - rims.inner(0)));
  int jumps = 0;
  int between = 0;
  for (int round = 0; round < 400; ++round) {
    for (std::size_t c = 0; c < scene.contacts.size(); ++c) {
      const Vec3& x = at(scene.positions, scene.contacts.point[c]);
      const auto both = [&](const Vec3& direction) {
        return std::pair{
            rims.fading_scale(scene.bodies, scene.positions, x, scene.contacts.tet[c], direction,
                              rims.reach(0), search),
            rims.scale(scene.bodies, scene.positions, x, scene.contacts.tet[c], direction, search)};
      };
      // Near the limit of the box's faces, so that sharp sides jump.
      const double along = 0.75 + scene.random.uniform(-1e-5, 1e-5);
      const Vec3 first = normalized(Vec3{along, std::sqrt(1.0 - along * along), 0.0});
      const Vec3 second = normalized(first + scene.random.point(-rotation, rotation));
      const auto [fading, sharp] = both(first);
      const auto [fading_then, sharp_then] = both(second);
      ASSERT_GE(fading, sharp);
      ASSERT_LE(std::abs(fading_then - fading), slope * length(second - first) + 1e-12);
      jumps += std::abs(sharp_then - sharp) > 0.1 ? 1 : 0;
      between += fading > sharp + 0.1 ? 1 : 0;
    }
  }
  EXPECT_GT(jumps, 100) << "sharp sides do";
  EXPECT_GT(between, 100);
}

TEST(RimFalloff, TheCacheChangesNothing) {
  for (const double most : {0.0, 1e-5, 1e-4, 1e-3, 1e-2}) {
    for (const double rotation : {0.0, 1e-3, 1e-2}) {
      Scene box(test::box_mesh({5, 5, 2}, {-2, -2, -1}, {2, 2, 1}), 1);
      const int clear = run(box, 46, most, rotation);
      ASSERT_GE(clear, 0) << most << ", " << rotation;
      // The last ten steps after a leap are quiet ones.
      if (most <= 1e-4) {
        EXPECT_GT(clear, 50) << most << ", " << rotation;
      }
      Scene ball(test::ball_mesh(5, {}, 2.0), 2);
      ASSERT_GE(run(ball, 46, most, rotation), 0) << most << ", " << rotation;
    }
  }
}

TEST(RimFalloff, TheCacheChangesNothingInSliversAndFlatTets) {
  for (const double height : {0.0, 1e-15, 1e-9, 1e-3}) {
    TetMesh mesh = test::box_mesh({4, 4, 3}, {-2, -2, -1}, {2, 2, 1});
    for (Vec3& p : mesh.points) {
      if (p.z > 0.0 && p.z < 0.9) p.z = -1.0 / 3.0 + height;  // the layer below it is squeezed
    }
    Scene scene(test::box_mesh({4, 4, 3}, {-2, -2, -1}, {2, 2, 1}), 3);
    for (std::size_t p = 0; p < mesh.points.size(); ++p) scene.positions[p] = mesh.points[p];
    for (const double most : {0.0, 1e-4}) ASSERT_GE(run(scene, 46, most, 1e-3), 0) << height << ", " << most;
  }
}

}  // namespace
}  // namespace palpate

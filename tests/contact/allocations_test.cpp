// No detection asks for memory once it has seen what a steady run looks like.
#include <array>
#include <gtest/gtest.h>
#include <string>

#include <palpate/detection.hpp>

#include "contact/swept_query.hpp"
#include "contact/variants.hpp"
#include "geometry/vector.hpp"
#include "support/count_allocations.hpp"
#include "support/meshes.hpp"

namespace palpate {
namespace {

/// Three boxes pressed into each other and a ball inside one: border edges, crossings, and depths that come
/// from neighbours and from the nearest surface. Enough tets and points for several chunks of each loop.
Bodies pressed_bodies() {
  Bodies bodies;
  bodies.add("lower", test::box_mesh({10, 10, 3}, {-1, -1, -0.5}, {1, 1, 0.1}));
  bodies.add("middle", test::box_mesh({11, 9, 3}, {-0.9, -1.1, -0.05}, {0.95, 0.9, 0.5}));
  bodies.add("upper", test::box_mesh({14, 13, 4}, {-0.8, -0.7, 0.3}, {0.9, 0.85, 1.2}));
  bodies.add("swallowed", test::ball_mesh(2, {0.1, 0.1, 0.8}, 0.15));
  return bodies;
}

struct Steady {
  long allocations = 0;
  std::size_t most_movers = 0;
  std::size_t fewest_contacts = 0;
  std::size_t fallbacks = 0;
};

/// Allocations after the tenth detection. Points tremble around their places; at most about 2 % change cell.
Steady steady_run(const Bodies& bodies, const DetectionSettings& settings, int threads) {
  constexpr int frames = 50;
  test::Random random(21);
  std::vector<Vec3> places(bodies.points_rest().begin(), bodies.points_rest().end());
  for (Vec3& p : places) p += random.point(-0.01, 0.01);  // so that cells do not end between them
  std::vector<Vec3> positions = places;
  Detector detector(bodies, settings, {}, threads);
  Steady steady{0, 0, positions.size(), 0};
  long before = 0;
  for (int frame = 0; frame < frames; ++frame) {
    if (frame == 10) before = allocations;
    for (std::size_t p = 0; p < positions.size(); ++p) positions[p] = places[p] + random.point(-6e-4, 6e-4);
    detector.detect(positions);
    if (frame < 10) continue;
    steady.most_movers = std::max(steady.most_movers, detector.counts().movers);
    steady.fewest_contacts = std::min(steady.fewest_contacts, detector.counts().contacts);
    steady.fallbacks += detector.counts().depth_fallbacks;
  }
  EXPECT_GT(before, 0) << "allocations are not counted";
  steady.allocations = allocations - before;
  return steady;
}

TEST(DetectorAllocations, ASteadyFrameMakesNoneInAnyWay) {
  const Bodies bodies = pressed_bodies();
  const auto points = static_cast<double>(bodies.points_rest().size());
  for (DetectionSettings variant : test::every_variant()) {
    if (variant.structure == Structure::brute) continue;  // slow, and has no memory of its own
    variant.cell_size = 0.13;
    for (const std::optional<int> slots : {std::optional<int>(), std::optional<int>(8)}) {
      variant.cells_per_primitive = slots;
      for (const int threads : {1, 3}) {
        const Steady steady = steady_run(bodies, variant, threads);
        EXPECT_EQ(steady.allocations, 0)
            << test::name_of(variant) << (slots ? ", 8 slots, " : ", exact, ") << threads << " threads";
        EXPECT_GT(steady.most_movers, 0U) << "some point must change its cell";
        EXPECT_LT(static_cast<double>(steady.most_movers), 0.021 * points);
        EXPECT_GT(steady.fewest_contacts, 150U);
        EXPECT_GT(steady.fallbacks, 0U);
      }
    }
  }
}

TEST(SweptQueryAllocations, ASteadyStepMakesNone) {
  const Bodies bodies = pressed_bodies();
  const std::vector<Vec3> start(bodies.points_rest().begin(), bodies.points_rest().end());
  test::Random random(4);
  const std::vector<std::uint8_t> none(bodies.bodies().size(), 0);
  SweptQuery query(bodies);
  for (const int threads : {1, 3}) {
    const parallel::Threads team(threads);
    long before = 0;
    for (int step = 0; step < 30; ++step) {
      if (step == 20) before = allocations;
      std::vector<Vec3> end = start;
      const long own = allocations;
      for (Vec3& p : end) p += random.point(-0.04, 0.04);
      EXPECT_GT(query.find(team, start, end, {none, none}, {.tolerance = 1e-6}).size(), 30U);
      if (step < 20) continue;
      EXPECT_EQ(allocations - own, 0) << step;
    }
    EXPECT_GT(before, 0) << "allocations are not counted";
  }
}

}  // namespace
}  // namespace palpate

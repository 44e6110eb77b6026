// What the clustered query remembers from frame to frame changes no contact: runs in which bodies tremble,
// drift, fly past and burst, against all pairs with the exact predicate in every frame.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <string>

#include "contact/all_pairs.hpp"
#include "contact/cluster_query.hpp"
#include "contact/list_plan.hpp"
#include "contact/scenes.hpp"
#include "geometry/predicates.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

using test::Pairs;
using test::Random;

constexpr int frames = 40;

/// How points move in a run.
struct Motion {
  const char* name;
  double tremble = 0.0;    ///< of each point around its place
  Vec3 drift{};            ///< of body 0 in each frame
  Vec3 fast{};             ///< of the last body in each frame
  int burst = 0;           ///< every so many frames all bodies are put elsewhere
  std::size_t fewest = 0;  ///< frames that must be asked by lists alone
};

constexpr double cell = 0.35;  // points may go 1 / 32 of it

std::vector<Motion> motions() {
  return {{"still", 0.0, {}, {}, 0, 30},
          {"trembling", 0.012 * cell, {}, {}, 0, 30},
          {"drifting", 1e-3 * cell, {0.004 * cell, 0.0, 0.002 * cell}, {}, 0, 20},
          {"one fast", 1e-3 * cell, {}, {-0.25 * cell, 0.1 * cell, 0.0}, 0, 0},
          {"bursts", 0.01 * cell, {}, {}, 9, 10},
          {"wild", 2.0 * cell, {}, {}, 0, 0}};
}

/// Boxes pressed into each other, a ball among them that one flies to, soups at the side, two of them folded
/// onto themselves.
struct Scene {
  Bodies bodies;
  std::vector<std::uint8_t> self_collision;
  std::vector<std::uint8_t> immovable;
  std::vector<std::array<Index, 2>> ignored{{1, 3}};

  explicit Scene(std::uint64_t seed) {
    Random random(seed);
    add("lower", test::box_mesh({4, 4, 2}, {-1, -1, -0.5}, {1, 1, 0.1}), true);
    add("upper", test::box_mesh({5, 4, 2}, {-0.9, -1.1, -0.05}, {0.95, 0.9, 0.6}), false);
    add("soup", test::soup(30, [&] { return random.point(-0.5, 0.5) + Vec3{2, 0, 0}; }), true);
    add("soups", test::soup(20, [&] { return random.grid_point(-2, 2, 0.25) + Vec3{2, 0, 0}; }), false);
    add("table", test::box_mesh({3, 3, 1}, {-1, -1, -0.7}, {1, 1, -0.45}), false);
    immovable.back() = 1;
    add("instrument", test::ball_mesh(2, {2.5, -0.5, 0.1}, 0.3), false);
  }
  void add(const std::string& name, TetMesh mesh, bool itself) {
    bodies.add(name, std::move(mesh));
    self_collision.push_back(itself ? 1 : 0);
    immovable.push_back(0);
  }
};

/// The positions of a run.
std::vector<std::vector<Vec3>> positions_of(const Scene& scene, const Motion& motion, std::uint64_t seed) {
  Random random(seed);
  const auto rest = scene.bodies.points_rest();
  std::vector<Vec3> places(rest.begin(), rest.end());
  for (Vec3& p : places) p += random.point(-0.01, 0.01);
  std::vector<std::vector<Vec3>> all;
  const auto shift = [&](Index body, const Vec3& by) {
    const Range range = at(scene.bodies.bodies(), body).points;
    for (Index p = range.begin; p < range.end; ++p) at(std::span(places), p) += by;
  };
  for (int frame = 0; frame < frames; ++frame) {
    if (motion.burst > 0 && frame % motion.burst == motion.burst - 1)
      for (Index b = 0; b < scene.bodies.body_count(); ++b) shift(b, random.point(-0.3, 0.3));
    shift(0, motion.drift);
    shift(scene.bodies.body_count() - 1, motion.fast);
    std::vector<Vec3> positions = places;
    for (Vec3& p : positions) p += motion.tremble * random.point(-1, 1);
    all.push_back(std::move(positions));
  }
  return all;
}

/// Asks frame after frame, as a detector does.
class Course {
 public:
  Course(const Scene& scene, Order order, const simd::ClusterKernels& kernels, int threads)
      : scene_(scene),
        threads_(threads),
        grid_(order),
        query_(scene.bodies, kernels),
        fixed_(std::vector<std::uint8_t>(scene.bodies.points_rest().size(), 1), marks(scene)) {}

  Pairs ask(const Lattice& lattice, const std::vector<Vec3>& x, bool new_lattice) {
    fixed_.place(threads_, lattice, x);
    if (query_.begin_frame(threads_, scene_.bodies, fixed_, new_lattice)) {
      grid_.build(threads_, lattice, fixed_);
    } else {
      grid_.skip(threads_, lattice, fixed_);
    }
    query_.find(threads_, scene_.bodies, x, {scene_.immovable, scene_.self_collision, scene_.ignored}, grid_,
                fixed_);
    ++modes[query_.last_mode()];
    Pairs pairs;
    for (const PointInTet& found : query_.found()) pairs.emplace_back(found.point, found.tet);
    in_order_found = pairs;
    std::sort(pairs.begin(), pairs.end());
    return pairs;
  }
  [[nodiscard]] QueryTally tally() const { return query_.tally(); }

  std::map<FrameMode, std::size_t> modes;
  Pairs in_order_found;

 private:
  static std::vector<std::uint8_t> marks(const Scene& scene) {
    std::vector<std::uint8_t> result;
    for (const Index body : scene.bodies.body_of_point()) result.push_back(at(scene.immovable, body));
    return result;
  }

  const Scene& scene_;
  parallel::Threads threads_;
  PointGrid grid_;
  ClusterQuery query_;
  FixedPositions fixed_;
};

Lattice lattice_around(const std::vector<std::vector<Vec3>>& all) {
  Box bounds;
  for (const std::vector<Vec3>& positions : all)
    for (const Vec3& p : positions) bounds.extend(p);
  return {bounds, cell};
}

class Coherence : public ::testing::TestWithParam<std::size_t> {};

TEST_P(Coherence, FindsWhatAllPairsGiveInEveryFrame) {
  const Motion motion = motions()[GetParam()];
  const Scene scene(3);
  const auto all = positions_of(scene, motion, 17);
  const Lattice lattice = lattice_around(all);
  std::vector<test::AllPairs> expected;
  const PairFilter may_touch{scene.immovable, scene.self_collision, scene.ignored};
  std::size_t pairs = 0;
  for (const std::vector<Vec3>& x : all) {
    expected.push_back(test::all_pairs(scene.bodies, x, may_touch, point_in_tet));
    pairs += expected.back().pairs.size();
  }
  EXPECT_GT(pairs, 1000U);
  const auto check = [&](Course run, const std::string& name) {
    for (std::size_t f = 0; f < all.size(); ++f) {
      SCOPED_TRACE(name + ", frame " + std::to_string(f));
      ASSERT_EQ(run.ask(lattice, all[f], f == 0), expected[f].pairs);
      ASSERT_EQ(run.tally().folded_pairs, expected[f].folded);
    }
    EXPECT_GE(run.modes[FrameMode::listed], motion.fewest) << name;
    EXPECT_GE(run.modes[FrameMode::listed_but_stale], motion.fast.x != 0.0 ? 15U : 0U) << name;
    EXPECT_GE(run.modes[FrameMode::all], motion.tremble > cell ? 30U : 0U) << name;
  };
  check({scene, Order::linear, simd::scalar::cluster_kernels(), 1}, "plain C++");
  test::for_each_simd_target([&](const char* target) {
    for (const int threads : {1, 3})
      check({scene, threads == 1 ? Order::linear : Order::z, simd::cluster_kernels(), threads},
            std::string(target) + ", " + std::to_string(threads));
  });
}

INSTANTIATE_TEST_SUITE_P(Motions, Coherence, ::testing::Range(std::size_t{0}, std::size_t{6}),
                         [](const auto& p) {
                           std::string name = motions()[p.param].name;
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

TEST(CoherenceOf, TheOrderFoundAndTheCountsDoNotDependOnThreads) {
  const Scene scene(3);
  for (const Motion& motion : motions()) {
    const auto all = positions_of(scene, motion, 17);
    const Lattice lattice = lattice_around(all);
    Course one(scene, Order::linear, simd::cluster_kernels(), 1);
    Course three(scene, Order::linear, simd::cluster_kernels(), 3);
    for (std::size_t f = 0; f < all.size(); ++f) {
      one.ask(lattice, all[f], f == 0);
      three.ask(lattice, all[f], f == 0);
      ASSERT_EQ(one.in_order_found, three.in_order_found) << motion.name << f;
      ASSERT_EQ(one.tally().candidates, three.tally().candidates) << motion.name << f;
    }
    EXPECT_EQ(one.modes, three.modes);
  }
}

/// Frames of a plan in which `stale_of(age of the lists)` of 1000 clusters are stale, and what they cost.
struct Counted {
  std::map<FrameMode, int> modes;
  double cost = 0.0;  ///< of a frame without lists: 1
};
template <class StaleOf>
Counted count(int n, StaleOf&& stale_of) {
  constexpr std::size_t clusters = 1000;
  ListPlan plan;
  Counted counted;
  int age = 0;
  for (int frame = 0; frame < n; ++frame) {
    const double stale = static_cast<double>(stale_of(++age)) / clusters;
    const FrameMode mode = plan.choose(clusters, stale_of(age));
    ++counted.modes[mode];
    if (mode == FrameMode::list) age = 0;
    switch (mode) {
      case FrameMode::all:
        counted.cost += 1.0;
        break;
      case FrameMode::list:
        counted.cost += 1.8;
        break;
      case FrameMode::listed:
        counted.cost += 0.45;
        break;
      case FrameMode::listed_but_stale:
        counted.cost += 0.2 + 0.8 * stale + 0.45 * (1.0 - stale);
        break;
    }
  }
  return counted;
}

TEST(ListPlan, MakesNoListsForASingleDetection) {
  ListPlan plan;
  EXPECT_EQ(plan.choose(100, 0), FrameMode::all);
  EXPECT_EQ(plan.choose(100, 0), FrameMode::list);
  EXPECT_EQ(plan.choose(100, 0), FrameMode::listed);
}

TEST(ListPlan, KeepsListsThatStayGood) {
  const Counted counted = count(1000, [](int) { return 0U; });
  EXPECT_EQ(counted.modes.at(FrameMode::list), 1);
  EXPECT_LT(counted.cost, 470);
}

TEST(ListPlan, CostsLittleWhereTheyNeverDo) {
  // Stale in the next frame, or in the one after that.
  for (const int good : {0, 1}) {
    const Counted counted = count(1000, [good](int age) { return age > good ? 1000U : 0U; });
    EXPECT_LT(counted.cost, 1000 * 1.03) << good;
    EXPECT_LT(count(60, [good](int age) { return age > good ? 1000U : 0U; }).cost, 60 * 1.1) << good;
  }
}

TEST(ListPlan, GainsBesideABodyThatNeverRests) {
  const Counted counted = count(1000, [](int) { return 50U; });
  EXPECT_LT(counted.cost, 1000 * 0.75);
  EXPECT_LT(counted.modes.at(FrameMode::list), 40);
}

TEST(ListPlan, MakesNewListsOnceOldOnesGetWorse) {
  const Counted counted = count(1000, [](int age) { return age > 10 ? 300U : 0U; });
  EXPECT_GT(counted.modes.at(FrameMode::list), 40);
  EXPECT_LT(counted.cost, 1000 * 0.65);
}

TEST(ListPlan, GoesOnFromItsNumbers) {
  ListPlan plan;
  Random random(1);
  for (int frame = 0; frame < 500; ++frame) {
    ASSERT_TRUE(ListPlan::allows(plan.numbers()));
    ListPlan other;
    other.set_numbers(plan.numbers());
    const auto stale = static_cast<std::size_t>(random.integer(0, frame % 90));
    ASSERT_EQ(plan.choose(100, stale), other.choose(100, stale));
    ASSERT_EQ(plan.numbers(), other.numbers());
  }
  EXPECT_FALSE(ListPlan::allows({0, 0, 65, 0, 1, 0, 0, 0}));
  EXPECT_FALSE(ListPlan::allows({0, 0, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace palpate

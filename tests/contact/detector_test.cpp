// Oracles: all pairs in rational arithmetic, written again here; the brute structure, itself checked against
// that; counts by hand for boxes.
#include <array>
#include <gtest/gtest.h>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "contact/same_detections.hpp"
#include "contact/scenes.hpp"
#include "contact/variants.hpp"
#include "geometry/box.hpp"
#include "geometry/vector.hpp"
#include "support/rational.hpp"

namespace palpate {
namespace {

using test::ContactScene;
using ContactSet = std::set<std::tuple<Index, Index, Index>>;

ContactSet set_of(const Contacts& contacts) {
  ContactSet set;
  for (std::size_t c = 0; c < contacts.size(); ++c)
    set.insert({contacts.point[c], contacts.body[c], contacts.tet[c]});
  EXPECT_EQ(set.size(), contacts.size()) << "no contact twice";
  return set;
}

ContactSet rational_contacts(const ContactScene& scene) {
  std::map<std::pair<Index, Index>, Index> lowest;  // (point, body) -> tet
  const auto& x = scene.positions;
  const Bodies& bodies = scene.bodies;
  for (Index p = 0; p < static_cast<Index>(x.size()); ++p) {
    for (Index t = 0; t < static_cast<Index>(bodies.tets().size()); ++t) {
      const Tet& tet = at(bodies.tets(), t);
      const Index a = at(bodies.body_of_point(), p);
      const Index b = at(bodies.body_of_point(), tet[0]);
      if (a == b || (at(scene.immovable, a) == 1 && at(scene.immovable, b) == 1)) continue;
      if (!box_of(std::span<const Vec3>(x), tet).contains(at(x, p))) continue;  // exact in doubles, and quick
      if (test::rational_point_in_tet(at(x, p), at(x, tet[0]), at(x, tet[1]), at(x, tet[2]), at(x, tet[3]))) {
        lowest.try_emplace({p, b}, t);
      }
    }
  }
  ContactSet set;
  for (const auto& [key, tet] : lowest) set.insert({key.first, key.second, tet});
  return set;
}

/// Border edges and crossings as (point in contact, free point, body, triangle), from all edges and all
/// triangles.
std::set<std::tuple<Index, Index, Index, Index>> rational_crossings(const ContactScene& scene,
                                                                    const ContactSet& contacts) {
  std::set<std::pair<Index, Index>> in;  // (point, body)
  for (const auto& [point, body, tet] : contacts) in.insert({point, body});
  std::set<std::tuple<Index, Index, Index, Index>> set;
  const auto& x = scene.positions;
  for (const Edge& edge : scene.bodies.edges()) {
    for (const auto& [p, q] : {std::pair{edge[0], edge[1]}, std::pair{edge[1], edge[0]}}) {
      for (Index body = 0; body < scene.bodies.body_count(); ++body) {
        if (!in.contains({p, body}) || in.contains({q, body})) continue;
        const Range range = at(scene.bodies.bodies(), body).triangles;
        for (Index t = range.begin; t < range.end; ++t) {
          const Triangle& c = at(scene.bodies.triangles(), t);
          test::Rational parameter;
          if (!box_of(std::span<const Vec3>(x), c).overlaps(box_of(std::span<const Vec3>(x), edge))) continue;
          if (test::rational_crossing(at(x, p), at(x, q), at(x, c[0]), at(x, c[1]), at(x, c[2]), parameter)) {
            set.insert({p, q, body, t});
          }
        }
      }
    }
  }
  return set;
}

std::set<std::tuple<Index, Index, Index, Index>> crossings_of(const Detector& detector) {
  std::set<std::tuple<Index, Index, Index, Index>> set;
  for (const Crossing& c : detector.crossings()) {
    const BorderEdge& e = at(detector.border_edges(), c.border_edge);
    set.insert({at(detector.contacts().point, e.contact), e.free_point,
                at(detector.contacts().body, e.contact), c.triangle});
  }
  EXPECT_EQ(set.size(), detector.crossings().size()) << "no crossing twice";
  return set;
}

template <class Choice, std::size_t n>
std::vector<Choice> choices(const std::array<std::string_view, n>& /*names*/) {
  std::vector<Choice> all;
  for (std::size_t i = 0; i < n; ++i) all.push_back(static_cast<Choice>(i));
  return all;
}
std::vector<Structure> every_structure() {
  return choices<Structure>(structure_names);
}
std::vector<Order> every_order() {
  return choices<Order>(order_names);
}

Detector detector_for(const ContactScene& scene, Structure structure, int threads = 1) {
  DetectionSettings settings;
  settings.structure = structure;
  return Detector(scene.bodies, settings, scene.immovable, threads);
}

class DetectorOn : public ::testing::TestWithParam<int> {};

TEST_P(DetectorOn, AgreesWithRationalArithmeticInTheSmall) {
  std::size_t contacts = 0;
  std::size_t crossings = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const ContactScene scene = test::make_contact_scene(GetParam(), seed);
    const ContactSet expected = rational_contacts(scene);
    const auto expected_crossings = rational_crossings(scene, expected);
    for (const Structure structure : every_structure()) {
      Detector detector = detector_for(scene, structure);
      detector.detect(scene.positions);
      ASSERT_EQ(set_of(detector.contacts()), expected);
      ASSERT_EQ(crossings_of(detector), expected_crossings);
    }
    contacts += expected.size();
    crossings += expected_crossings.size();
  }
  EXPECT_GT(contacts, 10U) << "the scenes must have contacts";
  EXPECT_TRUE(crossings > 5U || GetParam() == 2) << "identical bodies have no free points";
}

TEST_P(DetectorOn, EveryContactHasADepthAndADirection) {
  for (std::uint64_t seed = 1000; seed < 1100; ++seed) {
    const ContactScene scene = test::make_contact_scene(GetParam(), seed);
    Detector detector = detector_for(scene, Structure::compact);
    detector.detect(scene.positions);
    const Contacts& contacts = detector.contacts();
    for (std::size_t c = 0; c < contacts.size(); ++c) {
      ASSERT_TRUE(std::isfinite(contacts.depth[c]) && contacts.depth[c] >= 0.0)
          << "seed " << seed << " contact " << c;
      ASSERT_NEAR(length(contacts.direction[c]), 1.0, 1e-12) << "seed " << seed << " contact " << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, DetectorOn, ::testing::Range(0, test::contact_scene_kinds),
                         [](const auto& p) {
                           std::string name = test::contact_scene_name(p.param);
                           for (char& c : name) c = c == ' ' || c == '-' ? '_' : c;
                           return name;
                         });

TEST(Detector, FollowsMovingPointsOverManyFramesInEveryVariant) {
  // One detector each keeps its domain, last order and memory over frames in which points creep, burst, leave
  // the domain and come back.
  ContactScene scene = test::make_contact_scene(8, 3);
  const std::vector<DetectionSettings> variants = test::every_variant();
  std::vector<Detector> detectors;
  constexpr std::array<int, 4> threads{1, 2, 3, 5};
  for (std::size_t w = 0; w < variants.size(); ++w) {
    detectors.emplace_back(scene.bodies, variants[w], scene.immovable, threads[w % threads.size()]);
  }
  Detector brute = detector_for(scene, Structure::brute);
  test::Random random(11);
  std::size_t quiet_frames = 0;
  for (int frame = 0; frame < 200; ++frame) {
    const double stride = frame % 50 == 49 ? 3.0 : 1e-4;
    for (Vec3& p : scene.positions) {
      if (frame % 3 != 0 || random.chance(0.2)) p += stride * random.point(-1, 1);
    }
    if (frame % 50 == 0)
      scene.positions.assign(scene.bodies.points_rest().begin(), scene.bodies.points_rest().end());
    brute.detect(scene.positions);
    for (std::size_t w = 0; w < variants.size(); ++w) {
      SCOPED_TRACE("frame " + std::to_string(frame) + " " +
                   std::string(at(structure_names, int(variants[w].structure))) + " " +
                   std::string(at(order_names, int(variants[w].order))) + " " +
                   std::string(at(sort_names, int(variants[w].sort))));
      detectors[w].detect(scene.positions);
      ASSERT_NO_FATAL_FAILURE(test::expect_same(brute, detectors[w]));
      ASSERT_EQ(detectors[w].counts().sort.has_value(), variants[w].structure == Structure::compact);
    }
    quiet_frames += detectors[0].counts().movers < scene.positions.size() / 10 ? 1 : 0;
  }
  EXPECT_GT(quiet_frames, 150U) << "movers are only those that changed cell";
}

TEST(Detector, AdaptiveSortGoesToAFullSortInABurstAndBack) {
  ContactScene scene = test::make_contact_scene(8, 3);
  Detector detector = detector_for(scene, Structure::compact);
  test::Random random(5);
  const auto sort_after = [&](double stride) {
    for (Vec3& p : scene.positions) p += stride * random.point(-1, 1);
    detector.detect(scene.positions);
    return detector.counts().sort.value();
  };
  EXPECT_NE(sort_after(0.0), Sort::repair) << "the first frame has no last order";
  EXPECT_EQ(sort_after(1e-5), Sort::repair);
  EXPECT_NE(sort_after(0.5), Sort::repair) << "burst";
  EXPECT_EQ(sort_after(1e-5), Sort::repair) << "calm again";
}

TEST(Detector, TinyCellsInAHugeDomainCostNeitherMemoryNorTime) {
  // Two pairs of boxes a kilometre apart, cells of a micrometre: each edge alone passes thousands of them.
  Bodies bodies;
  const Vec3 far{1000, 700, 300};
  for (const Vec3& o : {Vec3{0, 0, 0}, Vec3{0.01, 0.015, 0.02}, far, far + Vec3{0.01, 0.015, 0.02}}) {
    bodies.add("b" + std::to_string(bodies.body_count()),
               test::box_mesh({2, 2, 2}, o, o + Vec3{0.03, 0.03, 0.03}));
  }
  DetectionSettings settings;
  settings.structure = Structure::brute;
  Detector brute(bodies, settings);
  brute.detect(bodies.points_rest());
  EXPECT_GT(brute.crossings().size(), 10U);
  settings.cell_size = 1e-6;
  for (const Structure structure : every_structure()) {
    for (const Order order : every_order()) {
      settings.structure = structure;
      settings.order = order;
      Detector detector(bodies, settings);
      detector.detect(bodies.points_rest());
      test::expect_same(brute, detector);
      EXPECT_EQ(detector.counts().cell_doublings, 10) << "1.2 km of 1 um: 2^30 cells";
      EXPECT_EQ(detector.counts().cell_size, std::ldexp(1e-6, 10));
    }
  }
}

TEST(Detector, CountsMoversByHand) {
  Bodies bodies;
  bodies.add("box", test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1}));
  DetectionSettings settings;
  settings.cell_size = 0.25;
  Detector detector(bodies, settings);
  std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
  detector.detect(x);
  EXPECT_EQ(detector.counts().movers, 8U) << "all, in a new domain";
  detector.detect(x);
  EXPECT_EQ(detector.counts().movers, 0U);
  x[3].x += 0.3;
  detector.detect(x);
  EXPECT_EQ(detector.counts().movers, 1U);
}

TEST(Detector, ReportsTheLoadOfItsCuckooTablesWhichIs71PercentWhereThereAreManyCells) {
  // Points far apart, one in each cell: as many keys as points.
  Bodies bodies;
  bodies.add("fine", test::box_mesh({30, 30, 30}, {0, 0, 0}, {30.1, 30.1, 30.1}));
  bodies.add("small", test::box_mesh({2, 2, 2}, {5.1, 5.1, 5.1}, {6.2, 6.2, 6.2}));
  DetectionSettings settings;
  settings.structure = Structure::cuckoo;
  settings.cell_size = 0.5;
  Detector detector(bodies, settings);
  detector.detect(bodies.points_rest());
  const CuckooCounts& points = detector.counts().cuckoo_points.value();
  EXPECT_GT(points.cells, 29000U);
  EXPECT_EQ(points.buckets, (points.cells + 408) / 409);
  EXPECT_EQ(points.slots, 576 * points.buckets);
  EXPECT_NEAR(points.occupancy(), 0.71, 0.01);
  EXPECT_EQ(points.growths + points.redistributions, 0U);
  const CuckooCounts& edges = detector.counts().cuckoo_edges.value();
  EXPECT_GT(edges.cells, 0U);
  EXPECT_LT(edges.occupancy(), 0.7101);
  detector = Detector(bodies, {});
  detector.detect(bodies.points_rest());
  EXPECT_FALSE(detector.counts().cuckoo_points || detector.counts().cuckoo_edges);
}

TEST(Detector, TwoImmovableBodiesDoNotTouch) {
  ContactScene scene = test::make_contact_scene(2, 5);
  scene.immovable.assign(scene.bodies.bodies().size(), 1);
  Detector detector = detector_for(scene, Structure::compact);
  detector.detect(scene.positions);
  EXPECT_EQ(detector.contacts().size(), 0U);
}

TEST(Detector, UnreferencedPointsTakeNoPart) {
  TetMesh mesh = test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1});
  mesh.points.push_back({0.5, 0.5, 5.5});  // inside the second body
  mesh.points.push_back({1e9, 1e9, 1e9});  // would stretch the domain
  Bodies bodies;
  bodies.add("with strays", mesh);
  bodies.add("other", test::box_mesh({1, 1, 1}, {0, 0, 5}, {1, 1, 6}));
  Detector detector(bodies, {});
  detector.detect(bodies.points_rest());
  EXPECT_EQ(detector.contacts().size(), 0U);
  EXPECT_LT(detector.counts().cell_size, 10.0);
}

TEST(Detector, RefusesBadInput) {
  Bodies bodies;
  EXPECT_THROW(Detector(bodies, {}), Error) << "no bodies";
  bodies.add("box", test::box_mesh({1, 1, 1}, {0, 0, 0}, {1, 1, 1}));
  DetectionSettings settings;
  settings.cell_size = 0.0;
  EXPECT_THROW(Detector(bodies, settings), Error);
  EXPECT_THROW(Detector(bodies, {}, {1, 1}), Error);
  Detector detector(bodies, {});
  std::vector<Vec3> x(bodies.points_rest().begin(), bodies.points_rest().end());
  EXPECT_THROW(detector.detect(std::span(x).first(7)), Error);
  x[2].y = std::nan("");
  EXPECT_THROW(detector.detect(x), Error);
  detector.detect(bodies.points_rest());  // and continues after a refusal
}

}  // namespace
}  // namespace palpate

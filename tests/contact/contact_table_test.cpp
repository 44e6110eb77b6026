// The table of contacts. Oracles: a map by (point, body) with the rules said once more; a detector that held
// nothing.
#include "contact/contact_table.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "contact/contact_tables.hpp"
#include "contact/detector_steps.hpp"
#include "contact/same_detections.hpp"
#include "contact/scenes.hpp"
#include "support/meshes.hpp"
#include "support/random.hpp"

namespace palpate {
namespace {

using Key = std::pair<Index, Index>;

/// What a contact is known by, in the simplest way.
struct Known {
  int seen = 0;
  int lost = 0;
  bool speculative = false;
  double mark = 0.0;  ///< kept as its damping of chatter
};

class Table : public testing::Test {
 protected:
  Table() {
    for (int i = 0; i < 4; ++i)
      bodies.add("box" + std::to_string(i), test::box_mesh({2, 2, 1}, {}, {1, 1, 1}));
  }
  /// Pairs of points and tets of other bodies, several of some.
  std::vector<PointInTet> some_pairs() {
    std::vector<PointInTet> pairs;
    for (Index p = 0; p < static_cast<Index>(bodies.points_rest().size()); ++p) {
      for (int i = random.integer(0, 3); i > 0; --i) {
        const Index tet = random.integer(0, static_cast<Index>(bodies.tets().size()) - 1);
        if (bodies.body_of(at(bodies.tets(), tet)) != at(bodies.body_of_point(), p))
          pairs.push_back({p, tet});
      }
    }
    for (std::size_t i = pairs.size(); i > 1; --i)
      std::swap(pairs[i - 1], at(pairs, random.integer(0, static_cast<Index>(i) - 1)));
    return pairs;
  }
  void detect() {
    const std::vector<PointInTet> pairs = some_pairs();
    tables.begin();
    tables.now().assign(parallel::Threads(2), bodies, bodies.points_rest(), pairs, &tables.last());
    rows.clear();
    for (const auto& [point, tet] : pairs) {
      const Key key(point, bodies.body_of(at(bodies.tets(), tet)));
      const auto [place, is_new] = rows.try_emplace(key, tet);
      if (!is_new) place->second = std::min(place->second, tet);
    }
  }
  Bodies bodies;
  test::Random random{7};
  ContactTables tables;
  std::map<Key, Index> rows;  ///< the lowest tet of each contact
};

TEST_F(Table, RowsAreInCanonicalOrderAndKnowTheirPlaceInTheLastTable) {
  std::map<Key, Index> place;
  for (int detection = 0; detection < 20; ++detection) {
    detect();
    const ContactTable& table = tables.now();
    ASSERT_EQ(table.size(), rows.size());
    std::size_t c = 0;
    std::map<Key, Index> now;
    for (const auto& [key, tet] : rows) {
      ASSERT_EQ(Key(table.contacts().point[c], table.contacts().body[c]), key);
      ASSERT_EQ(table.contacts().tet[c], tet);
      ASSERT_EQ(table.find(key.first, key.second), static_cast<Index>(c));
      const auto last = place.find(key);
      ASSERT_EQ(table.previous()[c], last == place.end() ? -1 : last->second);
      now[key] = static_cast<Index>(c++);
    }
    place = now;
  }
}

TEST_F(Table, ContactsThatComeAndGoKeepTheirStatesForAWhile) {
  std::map<Key, Known> known;
  detect();
  for (int step = 0; step < 80; ++step) {
    tables.now().begin_step(parallel::Threads(2));
    std::map<Key, Known> next;
    for (const auto& [key, k] : known) {
      const bool never_there = k.speculative && k.lost == 0;
      if (rows.contains(key) || never_there || k.lost == ContactTable::longest_absence) continue;
      next[key] = {0, k.lost + 1, false, k.mark};
    }
    ContactStates& states = tables.now().states();
    std::size_t c = 0;
    for (const auto& [key, tet] : rows) {
      Known k = known.contains(key) ? known[key] : Known{};
      ASSERT_EQ(states.seen[c], k.seen + 1) << "step " << step;
      ASSERT_EQ(states.lost[c], k.lost);
      ASSERT_EQ(states.chatter_damping[c], k.mark);
      ASSERT_EQ(states.speculative[c], 0);
      k = {k.seen + 1, 0, false, random.uniform(0.0, 1.0)};
      states.lost[c] = 0;
      states.chatter_damping[c++] = k.mark;
      next[key] = k;
    }
    known = next;
    // Contacts that are near, and not there.
    std::vector<ContactTable::Key> near;
    for (Index p = 0; p < static_cast<Index>(bodies.points_rest().size()); ++p) {
      const ContactTable::Key key(p, random.integer(0, 3));
      if (random.chance(0.1) && !rows.contains(key)) near.push_back(key);
    }
    tables.now().add_rows(near);
    for (const auto& [key, k] : known) {
      const Index row = tables.now().row_of(key.first, key.second);
      ASSERT_GE(row, 0);
      ASSERT_EQ(at(tables.now().states().lost, row), k.lost);
      ASSERT_EQ(at(tables.now().states().chatter_damping, row), k.mark);
    }
    for (const ContactTable::Key& key : near) {
      const Index row = tables.now().row_of(key.first, key.second);
      at(tables.now().states().seen, row) = 1;
      at(tables.now().states().speculative, row) = 1;
      known[key].seen = 1;
      known[key].speculative = true;
    }
    for (int detection = random.integer(1, 3); detection > 0; --detection) {
      detect();
      c = 0;
      for (const auto& [key, tet] : rows) {
        const int seen = known.contains(key) ? known[key].seen : 0;
        ASSERT_EQ(tables.now().states().seen[c], seen);
        if (seen == 0 && random.chance(0.3)) {  // it is met within the step
          tables.now().states().seen[c] = 1;
          tables.now().states().speculative[c] = 1;
          Known& k = known[key];
          k.seen = 1;
          k.speculative = true;
        }
        ++c;
      }
    }
    if (step % 9 == 8) {  // saved and restored
      const ContactHistory all = tables.now().history();
      ASSERT_EQ(all.point.size(), known.size());
      std::size_t i = 0;
      for (const auto& [key, k] : known) {
        ASSERT_EQ(Key(all.point[i], all.body[i]), key);
        ASSERT_EQ(all.states.lost[i], k.lost);
        ASSERT_EQ(all.states.chatter_damping[i++], k.mark);
      }
      tables.now().set_history(all);
    }
  }
}

TEST_F(Table, AStepThatIsTakenBackLeavesStatesAsTheyWere) {
  detect();
  for (int step = 0; step < 5; ++step) {
    tables.now().begin_step(parallel::Threads(1));
    detect();
  }
  const ContactHistory before = tables.now().history();
  tables.now().begin_step(parallel::Threads(1));
  for (double& damping : tables.now().states().chatter_damping) damping = 7.0;
  tables.now().undo_step();
  const ContactHistory after = tables.now().history();
  EXPECT_EQ(after.point, before.point);
  EXPECT_EQ(after.body, before.body);
  zip_columns(before.states, after.states, [](const auto& a, const auto& b) { EXPECT_EQ(a, b); });
}

/// Of exact, approximate and limited detection.
std::vector<DetectionSettings> settings_that_differ() {
  std::vector<DetectionSettings> all(3);
  all[1].cells_per_primitive = 1;
  all[1].cell_size = 0.1;
  all[2].budget = Budget{.tests = 300};
  return all;
}

TEST(Detector, GoesBackToResultsThatItHeld) {
  for (const DetectionSettings& settings : settings_that_differ()) {
    const test::ContactScene scene = test::make_contact_scene(8, 5);
    Detector one(scene.bodies, settings, scene.immovable, 1);
    Detector other(scene.bodies, settings, scene.immovable, 1);
    std::vector<Vec3> positions = scene.positions;
    test::Random random(11);
    const auto move = [&](double most) {
      for (Vec3& p : positions) p += random.point(-most, most);
    };
    for (int step = 0; step < 6; ++step) {
      one.detect(positions);
      other.detect(positions);
      test::expect_same(one, other);
      EXPECT_EQ(one.cell_domain().lower, other.cell_domain().lower);
      DetectorSteps::hold(one);
      const std::vector<Vec3> kept = positions;
      for (int i = 0; i < step; ++i) {
        move(step == 4 ? 10.0 : 0.01);  // out of the domain, too
        one.detect(positions);
      }
      DetectorSteps::swap_back(one);
      test::expect_same(one, other);
      EXPECT_EQ(one.cell_domain().lower, other.cell_domain().lower);
      positions = kept;
      move(0.005);
    }
  }
}

TEST(Detector, ADetectionThatFailsLeavesWhatWasHeld) {
  const test::ContactScene scene = test::make_contact_scene(8, 5);
  Detector detector(scene.bodies, {}, scene.immovable, 1);
  detector.detect(scene.positions);
  const Contacts before = detector.contacts();
  ASSERT_GT(before.size(), 0U);
  DetectorSteps::hold(detector);
  std::vector<Vec3> positions = scene.positions;
  positions[0].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_ANY_THROW(detector.detect(positions));
  DetectorSteps::swap_back(detector);
  EXPECT_EQ(detector.contacts().point, before.point);
  EXPECT_EQ(detector.contacts().depth, before.depth);
  detector.detect(scene.positions);
  EXPECT_EQ(detector.contacts().depth, before.depth);
}

}  // namespace
}  // namespace palpate

// The comparison of `palpate bench peers`, with mock peers: right, wrong in one pair, with candidates only.
// And the exact test of pairs against all pairs of a small scene.
#include "peers/contest.hpp"

#include <gtest/gtest.h>

#include <palpate/detection.hpp>
#include <palpate/error.hpp>

#include "peers/embree_peer.hpp"
#include "peers/known_modes.hpp"

namespace palpate::bench {
namespace {

/// Tests all pairs, and can make the result wrong.
class SlowPeer : public Peer {
 public:
  SlowPeer(const Course& course, std::function<void(std::vector<Pair>&)> spoil)
      : problem_(course.problem(Grouping::one)), spoil_(std::move(spoil)) {}
  Spent find(const Frame& frame, std::vector<Pair>& pairs) override {
    problem_.take(frame);
    pairs.clear();
    for (const Index first : problem_.first(0))
      for (Index second = problem_.second(0).begin; second < problem_.second(0).end; ++second)
        if (problem_.meets(first, second)) pairs.push_back({first, second});
    spoil_(pairs);
    return {2e-3, 1e-3};
  }

 private:
  Problem problem_;
  std::function<void(std::vector<Pair>&)> spoil_;
};

void leave(std::vector<Pair>&) {}
void drop_one(std::vector<Pair>& pairs) {
  pairs.pop_back();
}

/// Reports given seconds.
class Timed : public SlowPeer {
 public:
  Timed(const Course& course, double seconds) : SlowPeer(course, leave), seconds_(seconds) {}
  Spent find(const Frame& frame, std::vector<Pair>& pairs) override {
    SlowPeer::find(frame, pairs);
    return {0.0, seconds_};
  }

 private:
  double seconds_;
};

class Contest : public ::testing::TestWithParam<Task> {
 protected:
  Contest() : scene(measure::stacking_scene(2)), course{scene, scene.immovable(), GetParam()} {}

  ContestResult run(Answer answer, const std::function<void(std::vector<Pair>&)>& spoil) {
    Entrant entrant{"made up", 1, answer, {{"slow", [this, spoil] {
                                              return std::make_unique<SlowPeer>(course, spoil);
                                            }}}};
    std::vector<Entrant> entrants;
    add_ours(course, {1}, entrants);
    entrants.push_back(std::move(entrant));
    return run_contest(course, std::move(entrants), {.seconds = 0.0});
  }

  Entrant three_modes() {
    Entrant entrant{"made up", 1, Answer::exact, {}};
    for (const auto& [name, seconds] :
         {std::pair("slow", 3.0), std::pair("fast", 1.0), std::pair("middle", 2.0)})
      entrant.modes.push_back({name, [this, s = seconds] { return std::make_unique<Timed>(course, s); }});
    return entrant;
  }

  measure::QueryScene scene;
  Course course;
};

TEST_P(Contest, AllPairsAreTheLibrarysContacts) {
  const ContestResult result = run(Answer::exact, leave);
  EXPECT_GT(result.answers, 10U);
  EXPECT_EQ(result.frames, 3U);
  ASSERT_EQ(result.performances.size(), 2U);
  EXPECT_EQ(result.performances[1].milliseconds, std::vector<double>(3, 1.0))
      << "ms of the processor, for one thread";
  EXPECT_EQ(result.performances[1].missing + result.performances[1].extra, 0U);
}

TEST_P(Contest, AWrongPeerFailsIt) {
  EXPECT_THROW(run(Answer::exact, drop_one), Error);
  EXPECT_THROW(run(Answer::candidates, drop_one), Error);
}

TEST_P(Contest, WhatAPeerWithItsOwnTestGetsWrongIsCounted) {
  const ContestResult result = run(Answer::own_test, drop_one);
  // A point on a face has two tets: if one of them is missing, the point is not.
  EXPECT_GT(result.performances[1].missing, 0U);
  EXPECT_LE(result.performances[1].missing, 3U);
  EXPECT_EQ(result.performances[1].extra, 0U);
}

TEST_P(Contest, CandidatesMayBeTooMany) {
  const Index far = static_cast<Index>(scene.bodies.triangles().size()) - 1;
  const ContestResult result = run(Answer::candidates, [far](std::vector<Pair>& pairs) {
    pairs.push_back({0, far});
  });
  EXPECT_EQ(result.performances[1].missing, 0U);
  EXPECT_EQ(result.performances[1].extra, 3U) << "one in each frame";
}

TEST_P(Contest, TheFastestModeCounts) {
  const ContestResult result = run_contest(course, {three_modes()}, {.seconds = 0.0});
  EXPECT_EQ(result.performances[0].mode, "fast");
  ASSERT_EQ(result.trials.size(), 3U);
  EXPECT_EQ(result.trials[0].mode, "slow");
  EXPECT_EQ(result.trials[0].seconds, 3.0);
}

TEST_P(Contest, ASlowEntrantIsDropped) {
  const auto dropped = [&](double patience) {
    return run_contest(course, {three_modes(), three_modes()}, {.seconds = 0.0, .patience = patience})
        .dropped.size();
  };
  EXPECT_EQ(dropped(1.0), 0U) << "the fastest mode takes as long as that";
  EXPECT_EQ(dropped(0.9), 2U);
}

TEST_P(Contest, AnEntrantThatBreaksDownIsDropped) {
  const auto breaks = [](std::vector<Pair>&) { throw std::runtime_error("its process ended"); };
  const ContestResult result = run(Answer::exact, breaks);
  ASSERT_EQ(result.dropped.size(), 1U);
  EXPECT_EQ(result.dropped[0].reason, "its process ended");
  EXPECT_EQ(result.performances.size(), 1U);
}

TEST_P(Contest, EveryModeOfEmbreeFindsThem) {
  for (const EmbreeMode& mode : every_embree_mode()) {
    SCOPED_TRACE(mode.name());
    Entrant entrant{
        "Embree 3", 1, Answer::exact, {{mode.name(), [&] { return make_embree_peer(course, mode); }}}};
    EXPECT_NO_THROW(run_contest(course, {entrant}, {.seconds = 0.0}));
  }
}

TEST_P(Contest, FractionsOfMoversAreAsRequested) {
  const auto movers = [&](double wanted) {
    const measure::QueryScene moving = measure::stacking_scene(10, wanted);
    const Course its{moving, moving.immovable(), GetParam()};
    std::vector<Entrant> entrants;
    add_ours(its, {1}, entrants);
    return run_contest(its, std::move(entrants), {.seconds = 0.05}).movers;
  };
  EXPECT_NEAR(movers(0.02), 0.02, 0.015);
  EXPECT_NEAR(movers(0.1), 0.1, 0.05);
  EXPECT_GT(movers(1.0), 0.95);
}

/// Names of the remaining modes of a, b and c, with one thread and with two; "" for a dropped entrant.
std::vector<std::string> modes_left(const std::function<void(std::vector<Entrant>&)>& leave_out) {
  std::vector<Entrant> entrants;
  for (const int threads : {1, 2})
    entrants.push_back({"made up", threads, Answer::exact, {{"a", {}}, {"b", {}}, {"c", {}}}});
  leave_out(entrants);
  std::vector<std::string> result(2);
  for (const Entrant& entrant : entrants)
    for (const Mode& mode : entrant.modes) result[static_cast<std::size_t>(entrant.threads) - 1] += mode.name;
  return result;
}

TEST(KnownModes, HopelessOnesAreNotTriedInLargerScenes) {
  KnownModes known;
  known.add({{"made up", 1, "a", 1.0}, {"made up", 1, "b", 4.0}, {"made up", 1, "c", 4.1}}, 100);
  const auto left = [&](std::size_t tets) {
    return modes_left([&](std::vector<Entrant>& e) { known.leave_out_hopeless(tets, 10.0, e); });
  };
  EXPECT_EQ(left(101), (std::vector<std::string>{"ab", "abc"}));
  EXPECT_EQ(left(100), (std::vector<std::string>{"abc", "abc"})) << "a scene of as many is another trial";
}

TEST(KnownModes, ASlowModeIsLeftOutOfScenesThatAreNotSmaller) {
  KnownModes known;
  known.add({{"made up", 2, "a", 3.0}, {"made up", 2, "b", 2.5}}, 100);
  const auto left = [&](std::size_t tets, double patience) {
    return modes_left([&](std::vector<Entrant>& e) { known.leave_out_hopeless(tets, patience, e); });
  };
  EXPECT_EQ(left(100, 2.4), (std::vector<std::string>{"abc", "c"}))
      << "a mode that was not there may be faster";
  EXPECT_EQ(left(99, 2.4), (std::vector<std::string>{"abc", "abc"}));
  EXPECT_EQ(left(100, 2.6), (std::vector<std::string>{"abc", "abc"}));
}

TEST(KnownModes, TheFastestOfAsManyTetsIsLeft) {
  KnownModes known;
  known.add({{"made up", 1, "a", 2.0}, {"made up", 1, "b", 1.0}, {"made up", 1, "c", 3.0}}, 100);
  const auto left = [&](std::size_t tets) {
    return modes_left([&](std::vector<Entrant>& e) { known.leave_fastest(tets, e); });
  };
  EXPECT_EQ(left(100), (std::vector<std::string>{"b", "abc"}));
  EXPECT_EQ(left(101), (std::vector<std::string>{"abc", "abc"}));
}

INSTANTIATE_TEST_SUITE_P(Tasks, Contest, ::testing::Values(Task::points_in_tets, Task::edges_on_triangles),
                         [](const auto& tested) {
                           return tested.param == Task::points_in_tets ? "Points" : "Edges";
                         });

}  // namespace
}  // namespace palpate::bench

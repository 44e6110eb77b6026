#pragma once

#include <ctime>
#include <tbb/enumerable_thread_specific.h>
#include <vector>

#include "peers/peer.hpp"
#include "stopwatch.hpp"

namespace palpate::bench {

/// Answers that several threads find, without a lock.
class Answers {
 public:
  void add(const Pair& pair) { lists_.local().push_back(pair); }
  void clear() {
    for (std::vector<Pair>& list : lists_) list.clear();
  }
  void move_to(std::vector<Pair>& pairs) {
    pairs.clear();
    for (const std::vector<Pair>& list : lists_) pairs.insert(pairs.end(), list.begin(), list.end());
  }

 private:
  tbb::enumerable_thread_specific<std::vector<Pair>> lists_;
};

/// A peer that proposes pairs by their boxes, for the exact test.
class TimedPeer : public Peer {
 public:
  TimedPeer(const Course& course, Grouping grouping) : problem_(course.problem(grouping)) {}
  Spent find(const Frame& frame, std::vector<Pair>& pairs) override {
    answers_.clear();
    const double processor = processor_seconds();
    const Stopwatch watch;
    problem_.take(frame);
    search();
    const Spent spent{watch.seconds(), processor_seconds() - processor};
    answers_.move_to(pairs);
    return spent;
  }

 protected:
  /// Finds the answers in problem().
  virtual void search() = 0;
  [[nodiscard]] const Problem& problem() const { return problem_; }
  /// May be called by several threads at a time.
  void propose(Index first, Index second) {
    if (problem_.meets(first, second)) answers_.add({first, second});
  }
  void answer(const Pair& pair) { answers_.add(pair); }

 private:
  /// Of all threads of this process.
  static double processor_seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

  Problem problem_;
  Answers answers_;
};

}  // namespace palpate::bench

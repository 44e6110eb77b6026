#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "measure/query_scenes.hpp"
#include "peers/problem.hpp"

namespace palpate::bench {

/// Time of finding answers, s: wall time, and processor time, which depends less on other work of the
/// machine.
struct Spent {
  double passed = 0.0;
  double processor = 0.0;
};

/// Finds the answers of frame after frame, by its own method.
class Peer {
 public:
  Peer() = default;
  virtual ~Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  /// Replaces `pairs` by the answers, in any order; returns what finding them took. A point on the face of
  /// two tets may come with both.
  virtual Spent find(const Frame& frame, std::vector<Pair>& pairs) = 0;
};

/// How the answers of a peer compare with ours.
enum class Answer {
  exact,       ///< our exact test decides about its pairs: the same, or the benchmark fails
  own_test,    ///< its own test in floating point decides: differences are counted
  candidates,  ///< pairs that may meet, without a test: ours must be among them, or the benchmark fails
};

/// A mode of a peer; the fastest counts.
struct Mode {
  std::string name;
  std::function<std::unique_ptr<Peer>()> make;
};

/// A peer with so many threads.
struct Entrant {
  std::string name;
  int threads = 1;
  Answer answer = Answer::exact;
  std::vector<Mode> modes{};
};

/// A peer that is left out, and why.
struct Absentee {
  std::string name;
  std::string reason;
};

/// The input of entrants; must outlive them.
struct Course {
  const measure::QueryScene& scene;
  std::vector<std::uint8_t> immovable;
  Task task;
  [[nodiscard]] PairFilter filter() const { return {immovable, scene.self_collision}; }
  [[nodiscard]] Problem problem(Grouping grouping) const { return {scene.bodies, filter(), task, grouping}; }
};

/// Each adds its entrants, or none where it has nothing for the task.
void add_ours(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants);
void add_embree(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants);
void add_cgal(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants);
void add_bullet(const Course& course, std::vector<Entrant>& entrants);
void add_vtk(const Course& course, const std::vector<int>& threads, std::vector<Entrant>& entrants);

}  // namespace palpate::bench

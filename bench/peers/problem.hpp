#pragma once

#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "contact/pair_filter.hpp"
#include "geometry/box.hpp"

namespace palpate::bench {

/// The task of a contest.
enum class Task {
  points_in_tets,      ///< pairs of a point and a tet that it lies in
  edges_on_triangles,  ///< pairs of a border edge and a surface triangle of the body it is for, which it
                       ///< meets
};

/// A border edge: an end in contact with a body, and the free end.
struct AimedEdge {
  Index in;
  Index out;
  Index body;
};

struct Frame {
  std::span<const Vec3> positions;
  std::span<const AimedEdge> edges;
};

/// An answer: a point or border edge, and a tet or triangle.
struct Pair {
  Index first;
  Index second;
  friend auto operator<=>(const Pair&, const Pair&) = default;
};

/// Which primitives a peer puts into one structure.
enum class Grouping { one, per_body };

/// Both tasks in one form: primitives of two sides, in groups, with their boxes and the exact test of a pair.
class Problem {
 public:
  /// \param bodies, filter  must outlive the problem
  Problem(const Bodies& bodies, const PairFilter& filter, Task task, Grouping grouping);

  /// Sets the current frame, which must live until the next one.
  void take(const Frame& frame);

  [[nodiscard]] const Bodies& bodies() const { return *bodies_; }
  [[nodiscard]] Task task() const { return task_; }
  [[nodiscard]] std::span<const Vec3> positions() const { return frame_.positions; }
  /// The same on both sides.
  [[nodiscard]] std::size_t groups() const { return second_.size(); }
  [[nodiscard]] std::span<const Index> first(std::size_t group) const { return first_[group]; }
  [[nodiscard]] Range second(std::size_t group) const { return second_[group]; }
  /// Whether any pair of two groups can be an answer, wherever they are.
  [[nodiscard]] bool may_meet(std::size_t first, std::size_t second) const;

  [[nodiscard]] Box first_box(Index first) const;
  [[nodiscard]] Box second_box(Index second) const;
  /// Whether a pair is an answer, by the exact predicates of the library.
  [[nodiscard]] bool meets(Index first, Index second) const;

 private:
  [[nodiscard]] bool point_meets(Index point, const Tet& tet, Index tet_index) const;
  [[nodiscard]] bool edge_meets(const AimedEdge& edge, const Triangle& triangle) const;

  const Bodies* bodies_;
  PairFilter filter_;
  Task task_;
  Frame frame_;
  std::vector<std::vector<Index>> first_;
  std::vector<Range> second_;
};

}  // namespace palpate::bench

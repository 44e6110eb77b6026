#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "contact/deadline.hpp"
#include "parallel/parallel.hpp"

namespace palpate {

/// A plane through which a point leaves the body: its depth is
/// offset - (p - origin) . normal. Normals are not unit where planes were averaged.
using Plane = std::array<double, 4>;  // offset, normal

/// Weighted averages of planes on a graph: the plane of each node is the mean of its given planes and of its
/// neighbours' planes,
///   (W_i + sum_j m_ij) P_i = sum_k w_ik B_ik + sum_j m_ij P_j,   W_i = sum_k w_ik, m_ij = m_ji > 0.
///
/// Symmetric and positive definite where every connected part has a given plane; solved for the correction of
/// a first guess by conjugate gradients with the diagonal as preconditioner, the four components side by
/// side.
class PlaneSystem {
 public:
  struct Link {
    Index node;
    double weight;
  };
  struct Node {
    double diagonal = 1.0;  ///< sum of all weights; 1 where the node is left out
    Plane residual{};       ///< right side minus left side at the first guess
    Vec3 place;             ///< position relative to the origin of its planes
    double length = 0.0;    ///< a typical distance to its neighbours
    Index begin = 0;        ///< links are links[begin, end)
    Index end = 0;
  };

  std::vector<Node> nodes;
  std::vector<Link> links;

  /// Corrections of the first guess, valid until the next solve. Ends when one more sweep of averaging would
  /// rotate no normal by more than `tolerance` (radians) and change no depth by more than `tolerance` times
  /// the node's length; or after `most` iterations; or at the deadline. Returns the number of iterations.
  /// Parallel; without a deadline the same bits for every thread count.
  int solve(const parallel::Threads& threads, double tolerance, int most, const Deadline& deadline);
  /// solve() for residuals whose normals are all zero. The normals of the corrections are then zero, too.
  int solve_offsets(const parallel::Threads& threads, double tolerance, int most, const Deadline& deadline);
  [[nodiscard]] std::span<const Plane> corrections() const { return corrections_; }

 private:
  struct Sums {
    Plane sums{};
    bool far = false;  ///< some node is above the tolerance
  };
  [[nodiscard]] Sums total() const;
  template <std::size_t components>
  int solve_components(const parallel::Threads& threads, double tolerance, int most,
                       const Deadline& deadline);
  template <std::size_t components>
  void start(const parallel::Threads& threads, double tolerance);
  [[nodiscard]] bool beyond(const Node& node, const Plane& change, double tolerance) const;

  std::vector<Plane> corrections_;
  std::vector<Plane> search_;
  std::vector<Plane> product_;
  std::vector<Sums> partial_;
};

}  // namespace palpate

#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/types.hpp>

#include "contact/deadline.hpp"
#include "parallel/parallel.hpp"
#include "simd/plane_sweeps.hpp"

namespace palpate {

/// A plane through which a point leaves the body: its depth is
/// offset - (p - origin) . normal. Normals are not unit where planes were averaged.
using Plane = simd::Plane;  // offset, normal

/// Weighted averages of planes on a graph: the plane of each node is the mean of its given planes and of its
/// neighbours' planes,
///   (W_i + sum_j m_ij) P_i = sum_k w_ik B_ik + sum_j m_ij P_j,   W_i = sum_k w_ik, m_ij = m_ji > 0.
///
/// Symmetric and positive definite where every connected part has a given plane; solved for the correction of
/// a first guess by conjugate gradients with the diagonal as preconditioner, the four components side by
/// side.
class PlaneSystem {
 public:
  using Link = simd::PlaneLink;
  using Node = simd::PlaneNode;

  std::vector<Node> nodes;
  std::vector<Link> links;

  /// Corrections of the first guess, valid until the next solve. Ends when one more sweep of averaging would
  /// rotate no normal by more than `tolerance` (radians) and change no depth by more than `tolerance` times
  /// the node's length; or after `most` iterations; or at the deadline. Returns the number of iterations.
  /// Parallel; without a deadline the same bits for every thread count.
  int solve(const parallel::Threads& threads, double tolerance, int most, const Deadline& deadline);
  /// The same for one number without a unit at each node, instead of a plane: the first component of the
  /// residuals, whose others are zero. Ends when one more sweep would change none by more than `tolerance`.
  int solve_numbers(const parallel::Threads& threads, double tolerance, int most, const Deadline& deadline);
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
  Plane multiply(std::size_t begin, std::size_t end);
  template <std::size_t components>
  Plane move(const Plane& stride, std::size_t begin, std::size_t end);
  [[nodiscard]] simd::PlaneLists lists() {
    return {nodes.data(), links.data(), corrections_.data(), search_.data(), product_.data()};
  }
  template <std::size_t components>
  void start(const parallel::Threads& threads, double tolerance);
  template <std::size_t components>
  [[nodiscard]] bool beyond(const Node& node, const Plane& change, double tolerance) const;

  std::vector<Plane> corrections_;
  std::vector<Plane> search_;
  std::vector<Plane> product_;  ///< of the matrix with search_; later the next change
  std::vector<Sums> partial_;
};

}  // namespace palpate

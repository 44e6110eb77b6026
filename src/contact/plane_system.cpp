#include "contact/plane_system.hpp"

#include <cmath>
#include <cstddef>

#include "geometry/vector.hpp"
#include "room.hpp"

namespace palpate {
namespace {

constexpr std::size_t plane_grain = 512;

}  // namespace

PlaneSystem::Sums PlaneSystem::total() const {
  Sums sum;
  for (const Sums& part : partial_) {
    for (std::size_t k = 0; k < sum.sums.size(); ++k) sum.sums[k] += part.sums[k];
    sum.far |= part.far;
  }
  return sum;
}

template <std::size_t components>
bool PlaneSystem::beyond(const Node& node, const Plane& change, double tolerance) const {
  if constexpr (components == 1) return std::abs(change[0]) > tolerance;
  const Vec3 normal{change[1], change[2], change[3]};
  return squared_length(normal) > tolerance * tolerance ||
         std::abs(change[0] - dot(node.place, normal)) > tolerance * node.length;
}

/// The first search direction: the change that one sweep of averaging would make.
template <std::size_t components>
void PlaneSystem::start(const parallel::Threads& threads, double tolerance) {
  parallel::for_chunks(threads, nodes.size(), plane_grain,
                       [&](std::size_t begin, std::size_t end, std::size_t chunk) {
                         Sums sums;
                         for (std::size_t i = begin; i < end; ++i) {
                           const Node& node = nodes[i];
                           corrections_[i] = search_[i] = {};
                           for (std::size_t k = 0; k < components; ++k) {
                             search_[i][k] = node.residual[k] / node.diagonal;
                             sums.sums[k] += node.residual[k] * search_[i][k];
                           }
                           sums.far = sums.far || beyond<components>(node, search_[i], tolerance);
                         }
                         partial_[chunk] = sums;
                       });
}

/// Products of the matrix with the search direction; returns the sums of both multiplied.
template <std::size_t components>
Plane PlaneSystem::multiply(std::size_t begin, std::size_t end) {
  if constexpr (components > 1) return simd::multiply_planes(lists(), begin, end);
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    const Node& node = nodes[i];
    double product = node.diagonal * search_[i][0];
    for (Index l = node.begin; l < node.end; ++l) {
      const Link& link = at(links, l);
      product -= link.weight * at(search_, link.node)[0];
    }
    sum += product * search_[i][0];
    product_[i][0] = product;
  }
  return {sum};
}

/// Moves along the search direction. Then the product is the change that one more sweep would make; returns
/// the sums of residual times change.
template <std::size_t components>
Plane PlaneSystem::move(const Plane& stride, std::size_t begin, std::size_t end) {
  if constexpr (components > 1) return simd::move_planes(lists(), stride, begin, end);
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) {
    double& residual = nodes[i].residual[0];
    corrections_[i][0] += stride[0] * search_[i][0];
    residual -= stride[0] * product_[i][0];
    const double change = residual / nodes[i].diagonal;
    sum += residual * change;
    product_[i] = {change};
  }
  return {sum};
}

template <std::size_t components>
int PlaneSystem::solve_components(const parallel::Threads& threads, double tolerance, int most,
                                  const Deadline& deadline) {
  const std::size_t n = nodes.size();
  resize_with_room(corrections_, n);
  resize_with_room(search_, n);
  resize_with_room(product_, n);
  assign_with_room(partial_, parallel::chunk_count(n, plane_grain), Sums{});
  start<components>(threads, tolerance);
  Sums now = total();
  int iteration = 0;
  for (; iteration < most && now.far && !deadline.passed(); ++iteration) {
    parallel::for_chunks(threads, n, plane_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      partial_[chunk] = {multiply<components>(begin, end), false};
    });
    const Plane curvature = total().sums;
    Plane stride{};
    for (std::size_t k = 0; k < components; ++k) {
      if (curvature[k] > 0.0) stride[k] = now.sums[k] / curvature[k];
    }
    parallel::for_chunks(threads, n, plane_grain, [&](std::size_t begin, std::size_t end, std::size_t chunk) {
      Sums sums{move<components>(stride, begin, end), false};
      for (std::size_t i = begin; i < end && !sums.far; ++i)
        sums.far = beyond<components>(nodes[i], product_[i], tolerance);
      partial_[chunk] = sums;
    });
    const Sums next = total();
    if (!next.far) return iteration + 1;
    Plane keep{};
    for (std::size_t k = 0; k < components; ++k) {
      if (now.sums[k] > 0.0) keep[k] = next.sums[k] / now.sums[k];
    }
    parallel::for_each(threads, n, plane_grain, [&](std::size_t i) {
      for (std::size_t k = 0; k < components; ++k) search_[i][k] = product_[i][k] + keep[k] * search_[i][k];
    });
    now = next;
  }
  return iteration;
}

int PlaneSystem::solve(const parallel::Threads& threads, double tolerance, int most,
                       const Deadline& deadline) {
  return solve_components<4>(threads, tolerance, most, deadline);
}

int PlaneSystem::solve_numbers(const parallel::Threads& threads, double tolerance, int most,
                               const Deadline& deadline) {
  return solve_components<1>(threads, tolerance, most, deadline);
}

}  // namespace palpate

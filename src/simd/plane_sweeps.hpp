#pragma once

#include <array>
#include <cstddef>

#include <palpate/types.hpp>

/// Sweeps over the planes of contact/plane_system.hpp, with the components of a plane side by side. Bits
/// equal those of one component after the other.
namespace palpate::simd {

using Plane = std::array<double, 4>;
struct PlaneLink {
  Index node;
  double weight;
};
struct PlaneNode {
  double diagonal = 1.0;  ///< sum of all weights; 1 where the node is left out
  Plane residual{};       ///< right side minus left side at the first guess
  Vec3 place;             ///< position relative to the origin of its planes
  double length = 0.0;    ///< a typical distance to its neighbours
  Index begin = 0;        ///< links are links[begin, end)
  Index end = 0;
};
/// The lists of a system; (n_nodes) each but the links.
struct PlaneLists {
  PlaneNode* nodes;
  const PlaneLink* links;
  Plane* corrections;
  Plane* search;
  Plane* product;
};

/// Computes the products of the matrix with the search direction, for some nodes. Returns the sums of product
/// times direction.
Plane multiply_planes(const PlaneLists& all, std::size_t begin, std::size_t end);
/// Moves some nodes along the search direction. `product` becomes the residual divided by the diagonal.
/// Returns the sums of both multiplied.
Plane move_planes(const PlaneLists& all, const Plane& stride, std::size_t begin, std::size_t end);

}  // namespace palpate::simd

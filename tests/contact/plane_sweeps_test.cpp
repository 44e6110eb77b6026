// The sweeps over the planes of contacts on every SIMD target, against the same computed one component after
// the other.
#include "simd/plane_sweeps.hpp"

#include <bit>
#include <cstdint>
#include <gtest/gtest.h>
#include <vector>

#include "geometry/vector.hpp"
#include "support/random.hpp"
#include "support/simd_targets.hpp"

namespace palpate {
namespace {

std::uint64_t bits_of_number(double x) {
  return std::bit_cast<std::uint64_t>(x);
}

/// Nodes with links to random others, and random planes.
struct RandomPlanes {
  std::vector<simd::PlaneNode> nodes;
  std::vector<simd::PlaneLink> links;
  std::vector<simd::Plane> corrections;
  std::vector<simd::Plane> search;
  std::vector<simd::Plane> product;

  RandomPlanes(Index n, std::uint64_t seed) {
    test::Random random(seed);
    const auto plane = [&] {
      return simd::Plane{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1),
                         random.uniform(-1, 1)};
    };
    for (Index i = 0; i < n; ++i) {
      simd::PlaneNode node{.diagonal = random.uniform(1, 2), .residual = plane(), .place = {}};
      node.begin = static_cast<Index>(links.size());
      for (int l = random.integer(0, 5); l > 0; --l)
        links.push_back({random.integer(0, n - 1), random.uniform(0, 1)});
      node.end = static_cast<Index>(links.size());
      nodes.push_back(node);
      for (auto* list : {&corrections, &search, &product}) list->push_back(plane());
    }
  }
  simd::PlaneLists lists() {
    return {nodes.data(), links.data(), corrections.data(), search.data(), product.data()};
  }
};

TEST(PlaneSweeps, AreThoseOfOneComponentAfterTheOther) {
  constexpr Index n = 37;
  constexpr std::size_t begin = 2;
  const simd::Plane stride{0.5, -0.25, 2.0, 0.125};
  const RandomPlanes before(n, 17);
  test::for_each_simd_target([&](const char* target) {
    RandomPlanes all = before;
    const simd::Plane curvature = simd::multiply_planes(all.lists(), begin, n);
    const RandomPlanes multiplied = all;
    const simd::Plane size = simd::move_planes(all.lists(), stride, begin, n);
    for (std::size_t k = 0; k < 4; ++k) {
      double curvature_of_one = 0.0;
      double size_of_one = 0.0;
      for (std::size_t i = begin; i < n; ++i) {
        const simd::PlaneNode& node = before.nodes[i];
        double residual = node.residual[k];
        double product = node.diagonal * before.search[i][k];
        for (Index l = node.begin; l < node.end; ++l) {
          const auto& [other, weight] = at(before.links, l);
          product -= weight * at(before.search, other)[k];
        }
        ASSERT_EQ(bits_of_number(multiplied.product[i][k]), bits_of_number(product)) << target << ", " << i;
        curvature_of_one += product * before.search[i][k];
        residual -= stride[k] * product;
        const double change = residual / node.diagonal;
        size_of_one += residual * change;
        ASSERT_EQ(bits_of_number(all.nodes[i].residual[k]), bits_of_number(residual)) << target << ", " << i;
        ASSERT_EQ(bits_of_number(all.product[i][k]), bits_of_number(change)) << target << ", " << i;
        ASSERT_EQ(bits_of_number(all.corrections[i][k]),
                  bits_of_number(before.corrections[i][k] + stride[k] * before.search[i][k]))
            << target << ", " << i;
      }
      ASSERT_EQ(bits_of_number(curvature[k]), bits_of_number(curvature_of_one)) << target;
      ASSERT_EQ(bits_of_number(size[k]), bits_of_number(size_of_one)) << target;
    }
    ASSERT_EQ(all.nodes[0].residual, before.nodes[0].residual) << target;
  });
}

}  // namespace
}  // namespace palpate

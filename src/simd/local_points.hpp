#pragma once

#include <array>
#include <span>

#include <palpate/types.hpp>

#include "simd/cluster.hpp"

namespace palpate::simd {

/// The points of a cluster in float, relative to an origin nearby; fourth numbers mean nothing.
struct LocalPoints {
  alignas(64) std::array<std::array<float, 4>, Cluster::most_points> point;
};
/// Reads points, in a unit.
/// \param scale  1 / unit
void read_points(const Vec3* positions, std::span<const Index> points, const Vec3& origin, double scale,
                 LocalPoints& local);

}  // namespace palpate::simd

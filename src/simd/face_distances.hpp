#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <palpate/types.hpp>

namespace palpate::simd {

/// A point, by its number in a list, and a tet.
struct PointAndTet {
  std::uint32_t point;
  Index tet;
  std::uint32_t before;  ///< for the caller
};

/// For each i in `which`, computes squared[i][k], the squared distance of the point of pairs[i] from the face
/// opposite corner k of its tet. NaN counts as far.
void find_face_distances(std::span<const Vec3> positions, std::span<const Tet> tets,
                         std::span<const Vec3> points, std::span<const PointAndTet> pairs,
                         std::span<const std::uint32_t> which, std::span<std::array<double, 4>> squared);

}  // namespace palpate::simd

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// How surface triangles are joined over their sides, by the shape at rest (SurfaceNormals). Side i of a
/// triangle is opposite its corner i.
class SurfaceJoints {
 public:
  /// O(n) in triangles.
  explicit SurfaceJoints(const Bodies& bodies);

  /// The triangle over a side if that is no sharp crease; otherwise -1.
  [[nodiscard]] Index over(Index triangle, std::size_t side) const {
    const Side& joint = at(sides_, triangle)[side];
    return joint.bend == sharp ? -1 : joint.other;
  }
  /// The triangle over a side if both have one normal at `point`, an end of the side; otherwise -1.
  [[nodiscard]] Index smooth_over(Index triangle, std::size_t side, Index point) const {
    const bool jumps = at(sides_, triangle)[side].bend == bent && at(hollow_, point) != 0;
    return jumps ? -1 : over(triangle, side);
  }
  /// Creases of a triangle, as in simd::SmoothTriangle.
  [[nodiscard]] std::uint32_t creases(Index triangle) const { return at(creases_, triangle); }

 private:
  enum Bend : std::uint8_t { flat, bent, sharp };
  struct Side {
    Index other = -1;
    Bend bend = sharp;
  };
  /// The largest sines of the bends at a point: inwards, as in a cup, and outwards.
  struct Bends {
    double inwards = 0.0;
    double outwards = 0.0;
  };
  void find_bends(const Bodies& bodies, std::vector<Bends>& bends);
  template <class IsCrease>
  void add_creases(const Bodies& bodies, unsigned first_bit, IsCrease&& is_crease);

  std::vector<std::array<Side, 3>> sides_;  ///< (n_triangles)
  std::vector<std::uint8_t> hollow_;        ///< (n_points)
  std::vector<std::uint32_t> creases_;      ///< (n_triangles)
};

}  // namespace palpate

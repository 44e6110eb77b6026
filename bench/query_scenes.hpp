#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>

namespace palpate::bench {

/// Bodies whose points tremble around their places: in each frame, about 2 of 100 points have another cell
/// than in the frame before.
struct QueryScene {
  std::string name;
  Bodies bodies;
  std::vector<Vec3> places;
  std::vector<std::uint8_t> self_collision;  ///< per body
  double tremble = 0.0;                      ///< largest displacement along each axis
  /// Writes the positions of a frame: all frames are distinct, and follow from the scene and their number.
  void place(std::uint32_t frame, std::vector<Vec3>& positions) const;
};

/// The paper's stack of 20 membranes, each of n x n x 1 cells of 5 tets, pressed into each other unevenly so
/// that about 38 % of the points collide.
QueryScene stacking_scene(int cells);
/// Unstructured: a pile of balls and boxes of different resolution, turned, pressed into each other.
QueryScene pile_scene();
/// One body that collides with itself: a stack of membranes that are one body.
QueryScene self_scene();

}  // namespace palpate::bench

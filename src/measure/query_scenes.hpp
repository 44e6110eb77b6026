#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/model.hpp>

namespace palpate::measure {

/// Bodies whose points move a little from frame to frame, so that a wanted fraction of them changes its cell:
/// points move slightly around their positions. If all are to be movers, the whole scene also moves back and
/// forth along x.
struct QueryScene {
  std::string name;
  Bodies bodies;
  std::vector<Vec3> places;
  std::vector<std::uint8_t> self_collision;  ///< per body
  double tremble = 0.0;                      ///< largest displacement along each axis
  double shift = 0.0;                        ///< of all points in every other frame
  /// Per body: 1 for the lowest of several bodies, which is an obstacle.
  [[nodiscard]] std::vector<std::uint8_t> immovable() const;
  /// Writes the positions of a frame: all frames are different, and depend only on the scene and their
  /// number.
  void place(std::uint32_t frame, std::vector<Vec3>& positions) const;
};

/// The paper's stack of 20 membranes, each of n x n x 1 cells of 5 tets, pressed into each other unevenly so
/// that about 38 % of the points collide.
/// \param movers  wanted fraction of points in another cell than in the frame before, for cells of the mean
///                edge
QueryScene stacking_scene(int cells, double movers = 0.02);
/// The stack of stacking_scene() at rest, for simulations.
Model stacking_model(int cells);
/// Number of cells along a side of the membranes for about `tets` tets.
int stacking_cells(double tets);
/// Unstructured: a pile of balls and boxes of different resolution, rotated and pressed into each other.
QueryScene pile_scene();
/// Unstructured: layers of bent tubes of different resolution, one across the other, pressed into each other.
QueryScene tubes_scene();
/// Unstructured: two raptors (16 units long and in the same position), of which the right one is moved so
/// that they overlap.
QueryScene raptors_scene(TetMesh left, TetMesh right);
/// A shipped scene, from its bodies.
QueryScene shipped_scene(std::string name, Bodies bodies);
/// A body in self-collision: a stack of membranes that are one body.
QueryScene self_scene();

}  // namespace palpate::measure

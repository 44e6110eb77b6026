#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>
#include <palpate/types.hpp>

namespace palpate::io {

/// Which bodies a picture shows, and which are cut open.
struct CutSettings {
  std::vector<std::uint8_t> shown;  ///< (n_bodies); a body with 0 is left out
  std::vector<std::uint8_t> cut;    ///< (n_bodies); a body with 1 loses its part in front of the plane
  Vec3 point;                       ///< of the plane
  Vec3 normal;                      ///< of the plane, any length, towards the removed side
};

/// The remaining surface, with faces where the plane cuts tets.
struct CutSurface {
  std::vector<Vec3> points;  ///< (n x 3)
  std::vector<Triangle> triangles;
  std::vector<std::uint8_t> edges;     ///< (n_triangles) bit i: the side from corner i to the next is an edge
  std::vector<Index> body_of_point;    ///< (n)
  std::vector<double> values;          ///< (n), interpolated
  std::vector<Index> tet_of_triangle;  ///< (n_triangles) the tet of which it is a face or a section
};

/// Cuts bodies open. `values` are of the points (n_points). O(triangles + tets).
CutSurface cut_open(const Bodies& bodies, std::span<const Vec3> positions, std::span<const double> values,
                    const CutSettings& settings);

}  // namespace palpate::io

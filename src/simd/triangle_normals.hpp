#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/detection.hpp>
#include <palpate/types.hpp>

/// Normals of surfaces, and the planes of crossings, several at a time. Bits equal those of the same
/// operations one by one, in the order of geometry/vector.hpp.
namespace palpate::simd {

/// A surface triangle: its corners, and the fans whose normals are those of the corners.
struct SmoothTriangle {
  std::array<Index, 3> corners;
  std::array<Index, 3> fans;
  /// The first bit of each kind of crease: sharp ones, and those at hollow points. In a kind, bits 0-2: the
  /// edge opposite corner i is a crease; bits 3-5: corner i is an end of a crease.
  static constexpr unsigned sharp_bits = 0;
  static constexpr unsigned hollow_bits = 6;
  std::uint32_t creases = 0;
};
struct SmoothTriangles {
  std::span<const Vec3> positions;
  std::span<const SmoothTriangle> triangles;
  std::span<const Vec3> normals;  ///< (n_fans) unit
  double margin;  ///< a point is near a crease if its distance is below this many heights of the triangle
};

/// Fans: sets of triangles around points.
struct Fans {
  std::span<const Vec3> positions;
  std::span<const Index> begin;  ///< fan i is triangles[begin[i], begin[i + 1]), at least one
  std::span<const Triangle> triangles;
};

/// For each fan i in `which`, areas[i] becomes the sum of the area vectors of its triangles, and units[i]
/// its unit vector (zero where it has none). Faster if neighbours in `which` are of one length.
void find_fan_normals(const Fans& fans, std::span<const Index> which, std::span<Vec3> areas,
                      std::span<Vec3> units);

/// A point of a surface triangle.
struct PointOfTriangle {
  Index triangle;
  Vec3 x;
  double distance;  ///< from which its normal is asked for, m
};

/// A point whose normal needs more than interpolation.
struct Doubtful {
  std::uint32_t item;
  bool valid;  ///< the interpolation is valid, but the point is near a crease
  std::array<double, 3> weights;
};

/// Interpolates unit normals at points. Returns how many points it wrote into `doubtful`, which has room for
/// all.
std::size_t find_normals(const SmoothTriangles& triangles, std::span<const PointOfTriangle> points,
                         std::span<Vec3> normals, std::span<Doubtful> doubtful);

/// Border edges.
struct CrossedEdges {
  std::span<const Index> point_of_contact;
  std::span<const BorderEdge> edges;
  double shortest;  ///< squared length below which an edge is not valid
  double nearest;   ///< parameter below which a crossing is not valid
  double lost;      ///< the weight of a crossing is (1 / parameter^2 - lost) / length of the edge^2
};

/// The plane of a crossing, times its weight.
struct WeightedPlane {
  /// Distance of the point in contact from the plane, and unit normal, each times the weight; the weight;
  /// 1 / length of the edge^2.
  std::array<double, 6> sums;
  double distance;  ///< of the crossing from the point in contact
  double special;   ///< zero
};

/// Computes the planes of crossings. Returns how many crossings it wrote into `doubtful`, which has room for
/// all.
std::size_t find_planes(const CrossedEdges& edges, const SmoothTriangles& triangles,
                        std::span<const Crossing> crossings, std::span<WeightedPlane> planes,
                        std::span<Doubtful> doubtful);

}  // namespace palpate::simd

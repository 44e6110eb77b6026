#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include <palpate/types.hpp>

#include "simd/cluster.hpp"

namespace palpate::simd {

/// The box of the displacements of some points, rounded outwards; fourth numbers mean nothing.
struct DisplacementBox {
  alignas(32) std::array<float, 4> middle;
  std::array<float, 4> half;  ///< half of the sides
};
/// The displacement m[3] + x m[0] + y m[1] + z m[2] of a point (x, y, z).
using LinearMotion = std::array<std::array<double, 4>, 4>;

/// Box in double.
struct PlaceBox {
  Vec3 lower;
  Vec3 upper;
};
/// What is found of clusters, one after the other.
struct FollowedClusters {
  double* places;                  ///< six numbers of each: the lower and the upper corner of its box now
  DisplacementBox* displacements;  ///< now minus before
  DisplacementBox* remainders;     ///< displacements less those of the linear motion, where there is one
};
/// What is found of all these clusters together, without errors of rounding.
struct FollowedPoints {
  PlaceBox places;
  PlaceBox displacements;
  PlaceBox remainders;
  Vec3 sides;  ///< the longest ones of all boxes of places, along each axis
};
/// Finds the boxes of the points of each cluster. O(points).
/// \param points  of all clusters
/// \param common  the linear motion, or null
/// \param error   of the displacements of the linear motion, m
FollowedPoints follow(const Vec3* now, const Vec3* before, const Index* points,
                      std::span<const Cluster> clusters, const LinearMotion* common, double error,
                      const FollowedClusters& followed);

/// Columns of pairs of clusters.
struct MovingPairs {
  const Index* first;
  const Index* second;
  float* usual;        ///< motion per detection: the last, or half of the one before
  float* moved;        ///< sum of all motions
  const float* room;   ///< a pair is due when it has moved further than this,
  const float* apart;  ///< or as far as this
};
/// Adds to pairs [begin, end) a bound on how much nearer two points of the clusters came to each other.
/// Writes the numbers of the pairs that are due; returns how many they are. There must be room for 16 more.
std::size_t move_pairs(const DisplacementBox* motions, const MovingPairs& pairs, std::size_t begin,
                       std::size_t end, std::int32_t* due);

}  // namespace palpate::simd

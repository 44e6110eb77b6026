#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "geometry/vector.hpp"
#include "simd/face_distances.hpp"

namespace palpate {

/// Finds the surface near many points at once, each in a tet: the walks of ExitSearch, round by round,
/// several tets at a time. For points near the surface; a walk over many tets is given up.
///
/// find() visits the tets within the reach of each point, and keeps their distances for search(), which finds
/// the nearest surface of those points that need it.
class NearFaces {
 public:
  static constexpr std::size_t most_points = 64;

  /// Allocates memory for all walks, so that later steps allocate none.
  NearFaces()
      : pairs_(std::make_unique_for_overwrite<simd::PointAndTet[]>(2 * most_pairs)),
        squared_(std::make_unique_for_overwrite<std::array<double, 4>[]>(2 * most_pairs)),
        todo_(std::make_unique_for_overwrite<std::uint32_t[]>(most_pairs)),
        next_(std::make_unique_for_overwrite<std::uint32_t[]>(most_pairs)) {
    found_.reserve(most_pairs);
  }
  struct Point {
    Index tet;      ///< that contains the point
    Index without;  ///< leave out tets and triangles at this point; -1: none
    double reach;
  };
  struct Frame {
    const Bodies& bodies;
    std::span<const Vec3> positions;
    std::span<const Vec3> places;   ///< (n_points) at most most_points
    std::span<const Point> points;  ///< (n_points)
    double inexact;                 ///< by which distances may be wrong
  };
  struct Face {
    std::uint32_t point;
    Index triangle;
    double distance;
    Vec3 x;  ///< its nearest point
  };
  /// A search for the nearest surface.
  struct Search {
    std::uint32_t point;
    double bound;   ///< the surface is nearer
    double enough;  ///< the search may end at a face within this distance
  };

  /// Finds all surface faces within the reach of their points.
  void find(const Frame& frame);
  /// They; for each point in the order of its walk. Those of walks that were given up are incomplete.
  [[nodiscard]] std::span<const Face> found() const { return found_; }
  /// Searches for nearest faces, after find() for the same frame. Each point is searched for once.
  void search(const Frame& frame, std::span<const Search> searches);
  /// The distance of the nearest face that search() found; its bound if there was none.
  [[nodiscard]] double nearest(std::uint32_t point) const { return walks_[point].nearest; }
  [[nodiscard]] bool gave_up(std::uint32_t point) const { return walks_[point].gave_up; }

 private:
  static constexpr std::uint32_t none = 0xffffffff;
  static constexpr std::uint32_t most_tets = 24;
  static constexpr std::size_t most_pairs = most_points * most_tets;
  struct Walk {
    double radius2 = 0.0;  ///< squared, of the search
    double nearest = 0.0;
    double enough = 0.0;
    std::uint32_t last = none;   ///< newest pair
    std::uint32_t known = none;  ///< newest pair of an earlier walk
    std::uint32_t tets = 0;
    bool waits = false;  ///< for distances of a pair
    bool gave_up = false;
  };

  void add(std::uint32_t point, Index tet);
  [[nodiscard]] std::uint32_t pair_of(std::uint32_t last, Index tet) const;
  /// Visits the tets of `next_`, and those that are reached from there.
  template <class Found>
  void walk_on(const Frame& frame, Found&& found);
  template <class Found>
  void visit(const Frame& frame, std::uint32_t pair, Found&& found);

  // Memory for the longest walks. Most of it is never touched.
  std::unique_ptr<simd::PointAndTet[]> pairs_;
  std::unique_ptr<std::array<double, 4>[]> squared_;  ///< distances from faces, of each pair
  std::uint32_t count_ = 0;                           ///< of pairs
  std::unique_ptr<std::uint32_t[]> todo_;  ///< pairs of this round, whose distances are not known yet
  std::unique_ptr<std::uint32_t[]> next_;  ///< those of the next round
  std::uint32_t waiting_ = 0;              ///< number of these
  std::array<Walk, most_points> walks_{};
  std::vector<Face> found_;
};

}  // namespace palpate

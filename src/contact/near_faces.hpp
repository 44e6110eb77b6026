#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <palpate/mesh.hpp>

#include "simd/face_distances.hpp"

namespace palpate {

/// Finds the surface near many points at once, each in a tet: the walks of ExitSearch, round by round,
/// several tets at a time. For points near the surface; a walk over many tets is given up.
class NearFaces {
 public:
  static constexpr std::size_t most_points = 64;

  /// Reserves memory for all walks, so that later steps allocate none.
  NearFaces() {
    constexpr std::size_t most_pairs = most_points * most_tets;
    pairs_.reserve(most_pairs);
    before_.reserve(most_pairs);
    squared_.reserve(most_pairs);
    found_.reserve(most_pairs);
    walks_.reserve(most_points);
    nearest_.reserve(most_points);
  }
  /// A point. All surface faces within `reach` are wanted, and the distance of the nearest within `bound`.
  struct Point {
    Index without;  ///< leave out tets and triangles at this point; -1: none
    double reach;
    double bound;
  };
  struct Face {
    std::uint32_t point;
    Index tet;
    std::uint32_t opposite;  ///< corner
  };
  /// Squared distance of the nearest face found; infinite: none. Negative: the walk was given up.
  static constexpr double given_up = -1.0;

  /// \param places  (n_points) at most most_points
  /// \param tets    (n_points) that contain the points
  void find(const Bodies& bodies, std::span<const Vec3> positions, std::span<const Vec3> places,
            std::span<const Index> tets, std::span<const Point> points);
  /// The faces within reach; for each point in the order of its walk. Those of walks that were given up are
  /// incomplete.
  [[nodiscard]] std::span<const Face> found() const { return found_; }
  /// (n_points) given_up, or the squared distance of the nearest face.
  [[nodiscard]] std::span<const double> nearest() const { return nearest_; }

 private:
  struct Walk {
    double reach2;
    double radius2;      ///< of the search; it shrinks to the nearest face, but not below the reach
    std::uint32_t last;  ///< newest pair
    std::uint32_t tets;
  };
  static constexpr std::uint32_t none = 0xffffffff;
  static constexpr std::uint32_t most_tets = 24;

  void add(std::uint32_t point, Index tet);
  [[nodiscard]] bool has_reached(const Walk& walk, Index tet) const;
  void visit(const Bodies& bodies, std::span<const Point> points, std::uint32_t pair);

  std::vector<simd::PointAndTet> pairs_;
  std::vector<std::uint32_t> before_;           ///< (n_pairs) the pair of the same point before
  std::vector<std::array<double, 4>> squared_;  ///< (n_pairs) distances from faces
  std::vector<Walk> walks_;
  std::vector<double> nearest_;
  std::vector<Face> found_;
};

}  // namespace palpate

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate {

using PairOfBodies = std::pair<Index, Index>;  ///< the lower body first

[[nodiscard]] inline PairOfBodies pair_of(Index body_a, Index body_b) {
  return {std::min(body_a, body_b), std::max(body_a, body_b)};
}

/// What the contacts of two bodies say about the edges between them: how well they resist tilting, although
/// contacts at rims have little force, and how softly they act because they began deep.
///
/// In a fine mesh, the contacts away from rims extend nearly as far as all contacts. In two flush boxes of
/// two cells, only the middle contact is away from rims, and eight are at rims. The measure compares two
/// variances of contact positions: of all contacts of the pair, and weighted by their scale at rims
/// (RimFalloff). It is the smallest ratio of the second to the first over all directions.
class PairSupport {
 public:
  /// \param scales  (n_contacts) rim falloff of each, 0 to 1
  ///
  /// O(contacts log pairs). All contacts of a body with itself are one pair.
  void measure(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
               std::span<const double> scales);
  /// Lack of support of a pair. 0: points support the pair; 1: no point does, or all supporting points are on
  /// one line. O(log pairs).
  [[nodiscard]] double lack(Index body_a, Index body_b) const;
  /// Call after measure() for each contact that acts softly because it began deep: its stiffness relative to
  /// the usual one. O(log pairs).
  void soften(Index body_a, Index body_b, double part);
  /// The least of these of a pair, at most 1. O(log pairs).
  [[nodiscard]] double softness(Index body_a, Index body_b) const;

 private:
  /// Sums of weights, positions and products of two coordinates (xx, yy, zz, xy, xz, yz).
  struct Moments {
    double weight = 0.0;
    Vec3 first;
    std::array<double, 6> second{};
    void add(double weight, const Vec3& x);
    [[nodiscard]] std::array<double, 6> variance() const;
  };
  struct Support {
    PairOfBodies pair;
    Vec3 origin;  ///< near the contacts, so that sums lose no digits
    Moments all;
    Moments held;
    Moments normals;  ///< of the directions
    double lack = 0.0;
    double softness = 1.0;
  };
  [[nodiscard]] std::size_t find(Index body_a, Index body_b) const;
  [[nodiscard]] static double lack_of(const Support& support);

  std::vector<Support> pairs_;  ///< sorted
};

}  // namespace palpate

#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <palpate/detection.hpp>

#include "geometry/vector.hpp"

namespace palpate {

/// How well the contacts of two bodies hold them against tilting, although those at rims hold little.
///
/// Contacts of a fine mesh that are no rim spread nearly as far as all of them; of two boxes of two cells
/// that lie flush, one holds, in the middle, and eight are at rims. Compared are the variances of the places
/// of all contacts of the pair and of those same places weighted by their scales at rims (RimFalloff), in the
/// direction in which the second is the least part of the first.
class PairSupport {
 public:
  /// \param scales  (n_contacts) 0 to 1
  /// O(contacts log pairs). Contacts of a body with itself do not count.
  void measure(const Bodies& bodies, std::span<const Vec3> positions, const Contacts& contacts,
               std::span<const double> scales);
  /// 0: points hold the pair; 1: none do, or all that do lie in one line. O(log pairs).
  [[nodiscard]] double lack(Index body_a, Index body_b) const;

 private:
  using Pair = std::pair<Index, Index>;  ///< the lower body first
  /// Sums of weights, places and products of two coordinates (xx, yy, zz, xy, xz, yz).
  struct Moments {
    double weight = 0.0;
    Vec3 first;
    std::array<double, 6> second{};
    void add(double weight, const Vec3& x);
    [[nodiscard]] std::array<double, 6> variance() const;
  };
  struct Support {
    Pair pair;
    Vec3 origin;  ///< near the contacts, so that no digits are lost
    Moments all;
    Moments held;
    double lack = 0.0;
  };
  [[nodiscard]] static double lack_of(const Support& support);

  std::vector<Support> pairs_;  ///< sorted
};

}  // namespace palpate
